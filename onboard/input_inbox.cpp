#include "onboard/input_inbox.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cstring>

#include "core/check.hpp"

namespace kawara::onboard {

InputInbox::InputInbox() : ring_(1U << 20), event_fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  CORE_CHECK(event_fd_ >= 0);
}

InputInbox::~InputInbox() { close(event_fd_); }

bool InputInbox::Post(InputKind kind, core::MonoTime mono, std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(producers_);
  const bool taken = ring_.TryPush(Header{kind, mono}, bytes);
  const std::uint64_t one = 1;
  (void)!write(event_fd_, &one, sizeof(one));  // full counter: the reader is awake anyway
  return taken;
}

bool InputInbox::PostFrame(const FrameInput& frame) {
  std::array<std::uint8_t, sizeof(FrameInput)> bytes{};
  std::memcpy(bytes.data(), &frame, sizeof(frame));
  return Post(InputKind::kFrame, frame.arrival, bytes);
}

void InputInbox::Acknowledge() {
  std::uint64_t count = 0;
  (void)!read(event_fd_, &count, sizeof(count));
}

}  // namespace kawara::onboard
