#pragma once
#include <optional>

#include "core/time.hpp"

namespace kawara::onboard {

/// What the receiver's marks teach of a camera: how long after its trigger it exposes, and how much
/// later than that its own stamps lie. An exposure without a mark is then dated by whichever of the
/// two scatters less. Real-time safe; one thread.
class ShutterModel {
 public:
  struct Learnt {
    core::Duration mean{};
    core::Duration scatter{};  ///< mean absolute deviation
  };

  /// One exposure whose start is known from its mark.
  void Learn(core::MonoTime fired, core::MonoTime stamp, core::MonoTime start);
  /// Of one without. Empty until kEnough were seen.
  std::optional<core::MonoTime> StartOf(core::MonoTime fired, core::MonoTime stamp) const;

  /// Trigger to start of exposure; start of exposure to stamp. Zero before the first mark.
  const Learnt& lead() const { return lead_; }
  const Learnt& stamp() const { return stamp_; }
  int seen() const { return seen_; }  ///< stops counting at kEnough + 1

  static constexpr int kEnough = 16;

 private:
  void Smooth(Learnt& value, core::Duration seen) const;
  Learnt lead_;
  Learnt stamp_;
  int seen_ = 0;
};

}  // namespace kawara::onboard
