#include "onboard/rt_loop.hpp"

#include <poll.h>

#include <algorithm>
#include <cstring>

#include "onboard/realtime.hpp"

namespace kawara::onboard {
namespace {

drivers::ReconnectConfig PortConfig(const std::string& device, int baud_bps) {
  drivers::ReconnectConfig config;
  config.serial.device = device;
  config.serial.baud_bps = baud_bps;
  return config;
}

core::Severity SeverityOf(drivers::PortEventKind kind) {
  switch (kind) {
    case drivers::PortEventKind::kOpened:
    case drivers::PortEventKind::kTalking:
      return core::Severity::kInfo;
    case drivers::PortEventKind::kLost:
    case drivers::PortEventKind::kStillMissing:
    case drivers::PortEventKind::kSilent:
      break;
  }
  return core::Severity::kWarnHigh;
}

}  // namespace

void PortWriter::Add(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (bytes.size() > buffer_.size() - size_) {
    ++dropped_;
    return;
  }
  std::memcpy(buffer_.data() + size_, bytes.data(), bytes.size());
  size_ += bytes.size();
  Flush(now);
}

void PortWriter::Flush(core::MonoTime now) {
  if (size_ == 0 || !port_.is_open()) return;
  const std::size_t written = port_.Write(now, {buffer_.data(), size_});
  std::memmove(buffer_.data(), buffer_.data() + written, size_ - written);
  size_ -= written;
}

/// Acts on the world and passes the rest to the ring.
class RtLoop::ActingSink final : public CoreSink {
 public:
  ActingSink(OutputRing& ring, RtLoop& loop, drivers::Camera* camera)
      : ring_(ring), loop_(loop), camera_(camera) {}

  void OnInput(const Input& input) override { ring_.OnInput(input); }
  void OnFrame(const FrameInput& frame, bool selected) override { ring_.OnFrame(frame, selected); }
  void OnFix(const core::GnssFix& fix) override { ring_.OnFix(fix); }
  void OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) override {
    ring_.OnAhrs(sample, sampled);
  }
  void OnPose(const core::Pose& pose) override { ring_.OnPose(pose); }
  void OnNavigation(const estimation::NavigationReport& report) override {
    ring_.OnNavigation(report);
  }
  void OnClock(const estimation::ClockStatus& clock) override { ring_.OnClock(clock); }
  void OnEvent(const core::Event& event, core::GpsTime time) override {
    ring_.OnEvent(event, time);
  }
  void OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) override {
    ring_.OnNote(mono, note, time);
  }
  void OnPicture(const PictureOrder& order) override { ring_.OnPicture(order); }
  void OnExposurePose(const ExposurePose& pose) override { ring_.OnExposurePose(pose); }
  void Trigger(std::uint32_t sequence) override {
    // A camera that is away shows as a missed frame; its own thread tells why.
    if (camera_ != nullptr) (void)camera_->Trigger(sequence);
  }
  void Write(PortId port, std::span<const std::uint8_t> bytes) override {
    (port == PortId::kGps ? loop_.gps_writer_ : loop_.ahrs_writer_).Add(core::MonoNow(), bytes);
  }
  void SetBaud(PortId port, int baud_bps) override {
    // A rate the adapter cannot make shows as silence at that rate, which the caller watches.
    (void)(port == PortId::kGps ? loop_.gps_port_ : loop_.ahrs_port_).SetBaud(baud_bps);
  }

 private:
  OutputRing& ring_;
  RtLoop& loop_;
  drivers::Camera* camera_;
};

RtLoop::RtLoop(const OnboardConfig& config, core::Counters& counters, InputInbox& inbox,
               OutputRing& output, drivers::Camera* camera)
    : realtime_(config.realtime),
      inbox_(inbox),
      output_(output),
      gps_port_(PortConfig(config.gps.device, config.gps.baud_bps)),
      ahrs_port_(PortConfig(config.ahrs.device, config.ahrs.baud_bps)),
      gps_writer_(gps_port_),
      ahrs_writer_(ahrs_port_),
      sink_(std::make_unique<ActingSink>(output, *this, camera)),
      core_(config, counters, *sink_),
      late_max_us_(counters.Register("rt.wakeup_late_max_us")),
      late_over_10ms_(counters.Register("rt.wakeup_late_over_10ms")),
      output_refused_(counters.Register("rt.output_refused")),
      inbox_refused_(counters.Register("rt.inbox_refused")),
      write_dropped_(counters.Register("rt.port_writes_dropped")) {}

RtLoop::~RtLoop() { Stop(); }

void RtLoop::Start() {
  thread_ = std::thread([this] { Run(); });
}

void RtLoop::Stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void RtLoop::Run() {
  if (realtime_.priority > 0) {
    for (const std::string& complaint : BecomeRealtime("rt-loop", realtime_.priority)) {
      inbox_.Post(
          InputKind::kNote, core::MonoNow(),
          BytesOf(
              Pack(EventNote{core::Severity::kWarnLow, "realtime.degraded", complaint}).view()));
    }
  }
  while (!stopping_.load(std::memory_order_relaxed)) {
    heart_.Beat();
    const core::MonoTime deadline = core_.NextDeadline(core::MonoNow());
    Wait(deadline);
    const core::MonoTime now = core::MonoNow();
    if (now >= deadline) {
      Measure(deadline, now);
      Consume(InputKind::kTick, now, {});
    }
    ServicePort(PortId::kGps, gps_port_, gps_writer_, now);
    ServicePort(PortId::kAhrs, ahrs_port_, ahrs_writer_, now);
    ReadPort(PortId::kGps, gps_port_, InputKind::kGpsBytes, now);
    ReadPort(PortId::kAhrs, ahrs_port_, InputKind::kAhrsBytes, now);
    TakeInbox();
    output_.Ring();
  }
}

void RtLoop::Wait(core::MonoTime deadline) {
  const auto events = [](bool writing) {
    return static_cast<short>(POLLIN | (writing ? POLLOUT : 0));
  };
  // A closed port has fd -1, which poll() passes over.
  std::array<pollfd, 3> fds{{{gps_port_.fd(), events(gps_writer_.pending()), 0},
                             {ahrs_port_.fd(), events(ahrs_writer_.pending()), 0},
                             {inbox_.fd(), POLLIN, 0}}};
  const std::int64_t wait_ns = std::max<std::int64_t>((deadline - core::MonoNow()).count(), 0);
  const timespec timeout{wait_ns / 1'000'000'000, wait_ns % 1'000'000'000};
  (void)ppoll(fds.data(), fds.size(), &timeout, nullptr);
}

void RtLoop::ReadPort(PortId /*id*/, drivers::ReconnectingPort& port, InputKind kind,
                      core::MonoTime now) {
  // Bounded: a port that floods must not starve the others.
  for (int i = 0; i < 8; ++i) {
    const std::size_t n = port.Read(now, read_buffer_);
    if (n == 0) return;
    Consume(kind, port.first_byte_arrival(), {read_buffer_.data(), n});
    if (n < read_buffer_.size()) return;
  }
}

void RtLoop::ServicePort(PortId id, drivers::ReconnectingPort& port, PortWriter& writer,
                         core::MonoTime now) {
  port.Service(now);
  writer.Flush(now);
  drivers::PortEvent event;
  while (port.TryPopEvent(event)) {
    const bool opened = event.kind == drivers::PortEventKind::kOpened;
    const bool lost = event.kind == drivers::PortEventKind::kLost;
    if (lost) writer.Clear();
    PortNote note;
    note.port = id;
    note.open = port.is_open();
    note.changed = opened || lost;
    note.severity = SeverityOf(event.kind);
    note.text = event.text.view();
    const NoteBytes bytes = Pack(note);
    Consume(InputKind::kPort, now, BytesOf(bytes.view()));
  }
}

void RtLoop::TakeInbox() {
  inbox_.Acknowledge();
  while (inbox_.TryTake(
      [this](InputKind kind, core::MonoTime mono, std::span<const std::uint8_t> bytes) {
        if (kind != InputKind::kFrame) return Consume(kind, mono, bytes);
        FrameInput frame;
        std::memcpy(&frame, bytes.data(), sizeof(frame));
        frame.sequence = ++sequence_;
        core_.OnFrame(frame);
      })) {
  }
}

void RtLoop::Consume(InputKind kind, core::MonoTime mono, std::span<const std::uint8_t> bytes) {
  core_.OnInput({kind, ++sequence_, mono, bytes});
}

void RtLoop::Measure(core::MonoTime deadline, core::MonoTime woke) {
  const std::int64_t late_us = (woke - deadline).count() / 1000;
  late_max_us_.Set(std::max(late_max_us_.value(), late_us));
  if (late_us > 10'000) late_over_10ms_.Add();
  output_refused_.Set(static_cast<std::int64_t>(output_.refused()));
  inbox_refused_.Set(static_cast<std::int64_t>(inbox_.refused()));
  write_dropped_.Set(static_cast<std::int64_t>(gps_writer_.dropped() + ahrs_writer_.dropped()));
}

}  // namespace kawara::onboard
