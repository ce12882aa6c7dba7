#include "onboard/output_ring.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstring>

#include "core/check.hpp"

namespace kawara::onboard {
namespace {

/// All records are plain numbers in place (fixed-size Eigen members included), so they travel as
/// bytes.
template <class T>
T FromBytes(std::span<const std::uint8_t> bytes) {
  CORE_CHECK(bytes.size() == sizeof(T));
  T value;
  std::memcpy(static_cast<void*>(&value), bytes.data(), sizeof(T));
  return value;
}

}  // namespace

OutputRing::OutputRing(std::size_t capacity_bytes)
    : ring_(capacity_bytes), event_fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  CORE_CHECK(event_fd_ >= 0);
}

OutputRing::~OutputRing() { close(event_fd_); }

template <class T>
void OutputRing::Push(Kind kind, const T& value, core::GpsTime time, bool flag) {
  Header header;
  header.kind = kind;
  header.time = time;
  header.flag = flag;
  ring_.TryPush(header, {reinterpret_cast<const std::uint8_t*>(&value), sizeof(T)});
  rung_ = false;
}

void OutputRing::OnInput(const Input& input) {
  Header header;
  header.kind = Kind::kInput;
  header.input = input.kind;
  header.number = input.sequence;
  header.mono = input.mono;
  ring_.TryPush(header, input.bytes);
  rung_ = false;
}

void OutputRing::OnFrame(const FrameInput& frame, bool selected) {
  Push(Kind::kFrame, frame, {}, selected);
}
void OutputRing::OnFix(const core::GnssFix& fix) { Push(Kind::kFix, fix); }
void OutputRing::OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) {
  Push(Kind::kAhrs, sample, sampled);
}
void OutputRing::OnPose(const core::Pose& pose) { Push(Kind::kPose, pose); }
void OutputRing::OnNavigation(const estimation::NavigationReport& report) {
  Push(Kind::kNavigation, report);
}
void OutputRing::OnClock(const estimation::ClockStatus& clock) { Push(Kind::kClock, clock); }
void OutputRing::OnEvent(const core::Event& event, core::GpsTime time) {
  Push(Kind::kEvent, event, time);
}
void OutputRing::OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) {
  Header header;
  header.kind = Kind::kNote;
  header.mono = mono;
  header.time = time;
  ring_.TryPush(header, BytesOf(Pack(note).view()));
  rung_ = false;
}
void OutputRing::OnPicture(const PictureOrder& order) { Push(Kind::kPicture, order); }
void OutputRing::OnExposurePose(const ExposurePose& pose) { Push(Kind::kExposurePose, pose); }

void OutputRing::Ring() {
  if (rung_) return;
  rung_ = true;
  const std::uint64_t one = 1;
  (void)!write(event_fd_, &one, sizeof(one));
}

void OutputRing::Acknowledge() {
  std::uint64_t count = 0;
  (void)!read(event_fd_, &count, sizeof(count));
}

bool OutputRing::TryDeliver(CoreSink& sink) {
  return ring_.TryPop([&](const Header& header, std::span<const std::uint8_t> bytes) {
    switch (header.kind) {
      case Kind::kInput:
        return sink.OnInput({header.input, header.number, header.mono, bytes});
      case Kind::kFrame:
        return sink.OnFrame(FromBytes<FrameInput>(bytes), header.flag);
      case Kind::kFix:
        return sink.OnFix(FromBytes<core::GnssFix>(bytes));
      case Kind::kAhrs:
        return sink.OnAhrs(FromBytes<core::AhrsSample>(bytes), header.time);
      case Kind::kPose:
        return sink.OnPose(FromBytes<core::Pose>(bytes));
      case Kind::kNavigation:
        return sink.OnNavigation(FromBytes<estimation::NavigationReport>(bytes));
      case Kind::kClock:
        return sink.OnClock(FromBytes<estimation::ClockStatus>(bytes));
      case Kind::kEvent:
        return sink.OnEvent(FromBytes<core::Event>(bytes), header.time);
      case Kind::kNote: {
        EventNote note;
        if (Unpack(bytes, note)) sink.OnNote(header.mono, note, header.time);
        return;
      }
      case Kind::kPicture:
        return sink.OnPicture(FromBytes<PictureOrder>(bytes));
      case Kind::kExposurePose:
        return sink.OnExposurePose(FromBytes<ExposurePose>(bytes));
    }
  });
}

}  // namespace kawara::onboard
