#pragma once
#include <optional>

#include "core/config/constraints.hpp"
#include "core/time.hpp"
#include "vision/light_histogram.hpp"

namespace kawara::vision {

/// How bright pictures are to be, and what may be done for it. Lines of the onboard configuration.
struct AutoExposureConfig {
  double target = 0.18;             ///< light of the scene's mean, of what saturates: a grey card
  double min_exposure_s = 0.0001;   ///< the camera's shortest
  double exposure_step_s = 0.0001;  ///< the camera sets whole multiples of it
  /// Longest, before gain is used instead: at 1 m/s and 30 deg/s a picture of 6 px a degree is
  /// smeared by 1 px in 5 ms.
  double max_exposure_s = 0.005;
  double max_gain = 8.0;        ///< times the camera's least; 1: gain is not touched
  double response_gamma = 2.2;  ///< level (v/255)^gamma is light; 1 for raw sensor numbers
  double dead_band = 0.12;      ///< corrected to this near the target (as a ratio), from twice it
  double settle_s = 0.15;       ///< from setting a camera until its frames show it

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("target", target, Range{0.02, 0.8}, Optional{});
    v("min_exposure_s", min_exposure_s, Range{1e-6, 1.0}, Optional{});
    v("exposure_step_s", exposure_step_s, Range{1e-7, 0.1}, Optional{});
    v("max_exposure_s", max_exposure_s, Range{1e-6, 1.0}, Optional{});
    v("max_gain", max_gain, Range{1.0, 1000.0}, Optional{});
    v("response_gamma", response_gamma, Range{0.5, 4.0}, Optional{});
    v("dead_band", dead_band, Range{0.01, 0.5}, Optional{});
    v("settle_s", settle_s, Range{0.0, 5.0}, Optional{});
    v.Require(min_exposure_s <= max_exposure_s, "min_exposure_s", "at most max_exposure_s");
  }
};

struct ExposureSetting {
  double exposure_s = 0.001;
  double gain = 1.0;  ///< factor, 1 and above
  double product() const { return exposure_s * gain; }
};

/// Exposure and gain from one picture to the next, for a robot that drives from sun into shade.
/// Each picture says how bright the scene is under the setting it was taken with, so the wanted
/// setting follows directly; it is approached by a power of the ratio (kEagerness) that converges
/// even where response_gamma is wrong by a factor of two, and at once by a fixed factor where the
/// picture is washed out or black and says only that. Pictures taken before a setting has taken
/// effect are not looked at, so that delay does not make it swing; exposure goes in the camera's
/// steps and gain fills what is between them; once right, a picture may stray by twice the dead
/// band before anything is done, so that a camera that sets exposure in coarse steps does not swing
/// between two of them. There is no sum of past errors to wind up: every step begins at the setting
/// in force, which is always within the limits. Exposure is used before gain, because noise is
/// worse than blur below max_exposure_s.
///
/// Pure; one thread.
class AutoExposure {
 public:
  AutoExposure(const AutoExposureConfig& config, const ExposureSetting& begin);

  /// The setting to use from now on; nothing: leave it. `exposed`: start of the picture's exposure.
  std::optional<ExposureSetting> Next(const LightHistogram& light, core::MonoTime exposed);
  /// What the camera was really set to, after its own rounding, and when.
  void OnSet(const ExposureSetting& setting, core::MonoTime now);
  const ExposureSetting& setting() const { return setting_; }

  /// The part of the wanted change (as a logarithm) that is made at once.
  static constexpr double kEagerness = 0.7;

 private:
  double Ratio(const LightHistogram& light);
  bool IsRight(double wanted);
  ExposureSetting Split(double product) const;

  AutoExposureConfig config_;
  ExposureSetting setting_;
  core::MonoTime settled_;
  bool correcting_ = true;
  bool brighter_ = false;  ///< the last correction asked for more light
};

}  // namespace kawara::vision
