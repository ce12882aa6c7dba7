#include "onboard/event_marks.hpp"

#include <chrono>

namespace kawara::onboard {

void EventMarks::OnMark(core::GpsTime mark) {
  Slot& slot = slots_[next_slot_];
  next_slot_ = (next_slot_ + 1) % slots_.size();
  if (slot.mark.IsSet() && !slot.used) ++stats_.stray;
  slot = {mark, false};
}

std::optional<core::GpsTime> EventMarks::Take(core::GpsTime expected, core::Duration window) {
  Slot* best = nullptr;
  core::Duration best_error = window;
  for (Slot& slot : slots_) {
    if (!slot.mark.IsSet() || slot.used) continue;
    const core::Duration error = std::chrono::abs(slot.mark - expected);
    if (error > best_error) continue;
    best = &slot;
    best_error = error;
  }
  if (best == nullptr) return std::nullopt;
  best->used = true;
  ++stats_.used;
  missed_in_row_ = 0;
  return best->mark;
}

bool EventMarks::Miss() {
  ++stats_.missing;
  return ++missed_in_row_ == kGiveUp;
}

}  // namespace kawara::onboard
