#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "onboard/epoch_scheduler.hpp"
#include "onboard/input.hpp"

namespace kawara::onboard {

/// An exposure that was ordered and may or may not come back as a frame.
struct OrderedExposure {
  std::uint32_t trigger = 0;  ///< counted from 1
  PlannedExposure plan;
  core::MonoTime fired;
};

/// Finds for each frame the trigger that made it, by time, never by order alone: a missed, late or
/// double frame costs itself and shifts nothing. If the camera names its trigger, name and time
/// must agree. Real-time safe; one thread; fixed memory.
class FramePairing {
 public:
  struct Stats {
    std::int64_t paired = 0;
    std::int64_t missed = 0;     ///< triggers that got no frame within kPatience
    std::int64_t stray = 0;      ///< frames no trigger was waiting for
    std::int64_t doubled = 0;    ///< second frame of one trigger
    std::int64_t disagreed = 0;  ///< the camera named another trigger than its time stamp does
  };

  /// `lead`: trigger to start of exposure; `window`: how far the exposure may lie off that.
  FramePairing(core::Duration lead, core::Duration window) : FramePairing(lead, window, window) {}
  /// How far it may lie before and after: not the same for a camera that runs freely.
  FramePairing(core::Duration lead, core::Duration early, core::Duration late);

  void OnTrigger(const OrderedExposure& exposure);
  std::optional<OrderedExposure> OnFrame(const FrameInput& frame);
  /// Gives up on triggers older than kPatience; returns how many were given up now.
  int Expire(core::MonoTime now);
  const Stats& stats() const { return stats_; }

  static constexpr core::Duration kPatience = core::Milliseconds(2000);

 private:
  struct Slot {
    OrderedExposure exposure;
    bool waiting = false;
    bool used = false;  ///< already paired: kept to recognise a double
  };
  std::array<Slot, 16> slots_{};
  std::size_t next_slot_ = 0;
  core::Duration lead_;
  core::Duration early_;
  core::Duration late_;
  Stats stats_;
};

}  // namespace kawara::onboard
