#include "onboard/frame_pairing.hpp"

#include <chrono>

namespace kawara::onboard {

FramePairing::FramePairing(core::Duration lead, core::Duration early, core::Duration late)
    : lead_(lead), early_(early), late_(late) {}

void FramePairing::OnTrigger(const OrderedExposure& exposure) {
  Slot& slot = slots_[next_slot_];
  next_slot_ = (next_slot_ + 1) % slots_.size();
  if (slot.waiting) ++stats_.missed;
  slot = {exposure, true, false};
}

std::optional<OrderedExposure> FramePairing::OnFrame(const FrameInput& frame) {
  Slot* best = nullptr;
  core::Duration best_error = core::Duration::max();
  for (Slot& slot : slots_) {
    if (!slot.waiting && !slot.used) continue;
    const core::Duration after = frame.exposure_start - (slot.exposure.fired + lead_);
    if (after < -early_ || after > late_) continue;
    const core::Duration error = std::chrono::abs(after);
    if (error <= best_error) {
      best = &slot;
      best_error = error;
    }
  }
  if (best == nullptr) {
    ++stats_.stray;
    return std::nullopt;
  }
  if (best->used) {
    ++stats_.doubled;
    return std::nullopt;
  }
  if (frame.trigger_sequence != 0 && frame.trigger_sequence != best->exposure.trigger) {
    ++stats_.disagreed;
    return std::nullopt;
  }
  best->waiting = false;
  best->used = true;
  ++stats_.paired;
  return best->exposure;
}

int FramePairing::Expire(core::MonoTime now) {
  int expired = 0;
  for (Slot& slot : slots_) {
    if (!slot.waiting || now - slot.exposure.fired <= kPatience) continue;
    slot.waiting = false;
    ++stats_.missed;
    ++expired;
  }
  return expired;
}

}  // namespace kawara::onboard
