#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/time.hpp"
#include "drivers/camera_socket.hpp"
#include "sim/camera/picture_source.hpp"
#include "sim/dice.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

struct CameraOptions {
  double exposure_delay_s = 0.0005;   ///< trigger pulse to start of exposure
  double exposure_jitter_s = 0.0001;  ///< standard deviation of it
  double readout_s = 0.015;   ///< least time from start of exposure to the first byte of the frame
  bool names_trigger = true;  ///< false: as cameras of the kernel's, frames are numbered only
  double stamp_late_s = 0.0;  ///< its stamps lie so much after the start of the exposure, mean
  double stamp_jitter_s = 0.0;    ///< standard deviation of it
  bool signals_exposure = false;  ///< its signal line tells of exposures, not of triggers
  std::uint64_t seed = 3;
};

/// The camera itself, without the wire it hangs on: each trigger makes one exposure of the pictures
/// at that instant, and a frame that is ready a readout later. A trigger older than 100 ms when it
/// is read makes no exposure (missed). Its signal line (to a receiver's event input, say) is active
/// at each trigger, or at each exposure. Time is what the caller says. One thread.
class TriggeredCamera {
 public:
  struct Faults {
    bool hang = false;     ///< the two about the wire are its owner's to obey
    double miss = 0.0;     ///< share of triggers without an exposure
    double doubled = 0.0;  ///< share with a second one soon after
    bool late = false;
    bool dark = false;
    bool disconnected = false;
  };
  struct Exposure {
    std::uint32_t trigger_sequence = 0;
    std::uint32_t frame_sequence = 0;
    core::MonoTime mono;
    core::GpsTime gps;
  };
  struct Hooks {
    std::function<void(core::MonoTime)> signal;  ///< its signal line went active
    std::function<void(const Exposure&)> exposed;
  };
  struct Frame {
    drivers::CameraFrameHeader header;
    Picture picture;
    core::MonoTime ready;
  };
  struct Counters {
    std::uint64_t triggers = 0;
    std::uint64_t missed = 0;
    std::uint64_t doubled = 0;
    std::uint64_t spoiled = 0;  ///< exposed, but there was no picture
  };

  /// `clock` must outlive it.
  TriggeredCamera(const SimClock& clock, std::unique_ptr<PictureSource> pictures,
                  const CameraOptions& options, Hooks hooks);

  /// A trigger of the host, pulled at `pulse`, read at `now`. Returns what goes out because of it,
  /// in this order: nothing, a frame held back before, the frame of this exposure. Complaints of
  /// the pictures go to stderr.
  std::vector<Frame> OnTrigger(std::uint32_t sequence, core::MonoTime pulse, core::MonoTime now,
                               const Faults& faults);
  /// The host went away: what was held back is lost.
  void Forget() { held_back_.reset(); }

  /// Work can be done for the trigger that is expected next.
  bool WantsToPrepare(core::MonoTime now) const { return !prepared_ && now >= prepare_at_; }
  void Prepare(core::MonoTime now);

  const Counters& counters() const { return counters_; }
  /// Exposures whose picture had to be made after the trigger (PictureSource).
  std::uint64_t made_late() const { return pictures_->made_late(); }

 private:
  bool Happens(double share);
  std::optional<Frame> Expose(std::uint32_t sequence, core::MonoTime pulse, const Faults& faults);

  const SimClock& clock_;
  std::unique_ptr<PictureSource> pictures_;
  CameraOptions options_;
  Hooks hooks_;
  Dice dice_;
  Counters counters_;
  std::uint32_t frame_sequence_ = 0;
  core::MonoTime last_trigger_{};
  core::Duration period_{};  ///< between the last two triggers
  core::MonoTime prepare_at_{};
  bool prepared_ = false;
  std::optional<Frame> held_back_;  ///< fault `late`: goes out with the next trigger
};

}  // namespace kawara::sim
