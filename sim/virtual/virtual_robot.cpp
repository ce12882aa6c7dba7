#include "sim/virtual/virtual_robot.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <utility>

#include "onboard/counters_message.hpp"
#include "onboard/message_sink.hpp"
#include "onboard/phase1_assembler.hpp"

namespace kawara::sim {
namespace {

/// What a robot computer's scheduler and picture worker are taken to need: orders of magnitude of a
/// SCHED_FIFO loop and of threads of normal priority on an idle machine, not a measurement of one.
constexpr double kLoopWake_s = 30e-6, kLoopWakeMean_s = 20e-6;
constexpr double kThreadWake_s = 60e-6, kThreadWakeMean_s = 60e-6;
constexpr double kFrameBytesPerSecond = 500e6;
/// Preview and full picture of 2 Mpx on one core.
constexpr double kPreview_s = 0.025, kPicture_s = 0.070, kPictureMean_s = 0.015;
constexpr core::Duration kSystemClockPeriod = core::Seconds(60);

}  // namespace

/// The picture worker: what is made when, without a thread.
struct VirtualRobot::Pictures {
  std::optional<onboard::Phase1Assembler> assembler;
  std::map<std::int64_t, core::MonoTime> ordered_at;  ///< by epoch
  std::vector<std::vector<std::uint8_t>> packets;     ///< made since last looked
  core::MonoTime busy_until;
};

/// Says and acts for the core.
class VirtualRobot::Sink final : public onboard::MessageSink {
 public:
  explicit Sink(VirtualRobot& robot)
      : MessageSink(robot.config_.robot, frames,
                    [&robot](std::string_view channel, std::span<const std::uint8_t> bytes,
                             Reach /*reach*/) { robot.world_.emit(channel, bytes, robot.now_); }),
        robot_(robot) {}

  void OnInput(const onboard::Input& input) override {
    ++robot_.stats_.inputs;
    MessageSink::OnInput(input);
  }
  void OnFix(const core::GnssFix& fix) override {
    ++robot_.stats_.fixes;
    MessageSink::OnFix(fix);
  }
  void OnPose(const core::Pose& pose) override {
    ++robot_.stats_.poses;
    MessageSink::OnPose(pose);
  }
  void OnFrame(const onboard::FrameInput& frame, bool selected) override {
    ++robot_.stats_.inputs;
    MessageSink::OnFrame(frame, selected);
    if (!selected) frames.Release(frame.slot);
  }
  void OnPicture(const onboard::PictureOrder& order) override {
    Pictures& p = *robot_.pictures_;
    if (auto frame = frames.Get(order.slot)) p.assembler->OnFrame(order.epoch, std::move(frame));
    frames.Release(order.slot);
    p.ordered_at[order.epoch] = std::max(robot_.now_, p.busy_until);
    p.busy_until = p.ordered_at[order.epoch] + robot_.Latency(kPicture_s, kPictureMean_s);
  }
  void OnExposurePose(const onboard::ExposurePose& pose) override;
  void Trigger(std::uint32_t sequence) override {
    if (robot_.world_.trigger) robot_.world_.trigger(sequence, robot_.now_);
  }
  void Write(onboard::PortId port, std::span<const std::uint8_t> bytes) override {
    LinkOf(port).Write(robot_.now_, bytes);
  }
  void SetBaud(onboard::PortId port, int baud_bps) override { LinkOf(port).SetBaud(baud_bps); }

  onboard::FrameTable frames;

 private:
  VirtualLink& LinkOf(onboard::PortId port) {
    return port == onboard::PortId::kGps ? robot_.gps_ : robot_.ahrs_;
  }
  VirtualRobot& robot_;
};

/// The pictures are made here and now, but go out when a computer would have been done with them.
void VirtualRobot::Sink::OnExposurePose(const onboard::ExposurePose& pose) {
  MessageSink::OnExposurePose(pose);
  Pictures& p = *robot_.pictures_;
  if (!p.assembler) return;
  const auto ordered = p.ordered_at.extract(pose.epoch);
  const core::MonoTime begun = ordered ? ordered.mapped() : robot_.now_;
  p.assembler->OnPose(pose);
  while (p.assembler->Work()) {
  }
  const core::MonoTime soon = robot_.now_ + robot_.Latency(kThreadWake_s, kThreadWakeMean_s);
  const core::MonoTime previewed = std::max(soon, begun + core::DurationFromSeconds(kPreview_s));
  const core::MonoTime done =
      std::max(previewed, begun + robot_.Latency(kPicture_s, kPictureMean_s));
  for (std::size_t i = 0; i < p.packets.size(); ++i) {
    const bool last = i + 1 == p.packets.size();
    robot_.packets_.emplace(last ? done : previewed, std::move(p.packets[i]));
  }
  p.packets.clear();
  robot_.Post(done,
              {.kind = onboard::InputKind::kPictureDone, .mono = done, .bytes = {}, .frame = {}});
}

core::Expected<std::unique_ptr<VirtualRobot>> VirtualRobot::Create(
    const onboard::OnboardConfig& config, World world, std::uint64_t seed, core::MonoTime now) {
  std::unique_ptr<VirtualRobot> robot(new VirtualRobot(config, std::move(world), seed, now));
  if (!robot->world_.trigger) return robot;
  VirtualRobot& r = *robot;
  auto assembler = onboard::Phase1Assembler::Create(
      config.picture,
      {config.robot.name, config.robot.mission, config.camera.make, config.camera.model},
      [&r](std::span<const std::uint8_t> bytes) {
        r.pictures_->packets.emplace_back(bytes.begin(), bytes.end());
        ++r.stats_.pictures;
      },
      [&r](const core::Error& error) {
        const auto note = onboard::Pack(
            onboard::EventNote{core::Severity::kWarnHigh, "phase1.damaged_frame", error.message});
        const auto bytes = onboard::BytesOf(note.view());
        r.Post(r.now_, {.kind = onboard::InputKind::kNote,
                        .mono = r.now_,
                        .bytes = {bytes.begin(), bytes.end()},
                        .frame = {}});
      });
  if (!assembler) return tl::unexpected(assembler.error());
  r.pictures_->assembler.emplace(std::move(*assembler));
  return robot;
}

VirtualRobot::VirtualRobot(const onboard::OnboardConfig& config, World world, std::uint64_t seed,
                           core::MonoTime now)
    : config_(config),
      world_(std::move(world)),
      dice_(seed),
      now_(now),
      gps_(onboard::PortId::kGps, config.gps.device, config.gps.baud_bps, world_.gps),
      ahrs_(onboard::PortId::kAhrs, config.ahrs.device, config.ahrs.baud_bps, world_.ahrs),
      pictures_(std::make_unique<Pictures>()),
      sink_(std::make_unique<Sink>(*this)),
      core_(std::make_unique<onboard::RobotCore>(config, counters_, *sink_)),
      frames_(counters_.Register("camera.frames")),
      edges_(counters_.Register("pps.edges")),
      deadline_(now),
      wake_(now),
      next_second_(now),
      next_system_clock_(now) {
  if (world_.trigger) OnCameraPort(now, true);
  if (!config_.gps.pps.device.empty())
    PostPort(now + Latency(kThreadWake_s, kThreadWakeMean_s), onboard::PortId::kPps, true,
             "the pulse line is there");
}

VirtualRobot::~VirtualRobot() = default;

core::Duration VirtualRobot::Latency(double least_s, double mean_s) {
  return core::DurationFromSeconds(least_s + mean_s * dice_.Exponential());
}

void VirtualRobot::Post(core::MonoTime at, Item item) { inbox_.emplace(at, std::move(item)); }

void VirtualRobot::PostPort(core::MonoTime at, onboard::PortId port, bool there,
                            std::string_view text) {
  const auto note = onboard::Pack(onboard::PortNote{
      port, there, true, there ? core::Severity::kInfo : core::Severity::kWarnHigh, text});
  const auto bytes = onboard::BytesOf(note.view());
  Post(at, {.kind = onboard::InputKind::kPort,
            .mono = at,
            .bytes = {bytes.begin(), bytes.end()},
            .frame = {}});
}

void VirtualRobot::OnCameraPort(core::MonoTime now, bool there) {
  PostPort(now + Latency(kThreadWake_s, kThreadWakeMean_s), onboard::PortId::kCamera, there,
           there ? "the camera is there" : "camera " + config_.camera.path + ": connection closed");
}

void VirtualRobot::OnPulse(core::MonoTime now, const drivers::PpsEdge& edge) {
  if (config_.gps.pps.device.empty()) return;
  edges_.Add();
  const auto packed = onboard::Pack(edge.sequence);
  Post(now + Latency(kThreadWake_s, kThreadWakeMean_s), {.kind = onboard::InputKind::kPulse,
                                                         .mono = edge.mono,
                                                         .bytes = {packed.begin(), packed.end()},
                                                         .frame = {}});
}

bool VirtualRobot::OnFrame(core::MonoTime now, const TriggeredCamera::Frame& frame) {
  frames_.Add();
  const double transfer_s = static_cast<double>(frame.picture.jpeg.size()) / kFrameBytesPerSecond;
  const core::MonoTime arrival = std::max(now, frame.ready) +
                                 core::DurationFromSeconds(transfer_s) +
                                 Latency(kThreadWake_s, kThreadWakeMean_s);
  auto pixels = std::make_shared<drivers::Frame>();
  pixels->sequence = frame.header.sequence;
  pixels->trigger_sequence = frame.header.trigger_sequence;
  pixels->exposure_start = core::MonoTime::FromNs(frame.header.exposure_start_mono_ns);
  pixels->arrival = arrival;
  pixels->width = frame.picture.width;
  pixels->height = frame.picture.height;
  pixels->bytes = frame.picture.jpeg;
  onboard::FrameInput input;
  input.frame_sequence = pixels->sequence;
  input.trigger_sequence = pixels->trigger_sequence;
  input.exposure_start = pixels->exposure_start;
  input.arrival = arrival;
  const auto slot = sink_->frames.Put(std::move(pixels));
  if (!slot) return false;
  input.slot = *slot;
  Post(arrival, {.kind = onboard::InputKind::kFrame, .mono = arrival, .bytes = {}, .frame = input});
  return true;
}

core::MonoTime VirtualRobot::NextStep() const {
  core::MonoTime next = std::min({wake_, next_second_, next_system_clock_});
  if (!packets_.empty()) next = std::min(next, packets_.begin()->first);
  if (!noticed_ && !inbox_.empty()) next = std::min(next, inbox_.begin()->first);
  return next;
}

/// Something is here to be read: the loop wakes for it, once for all that comes until it does.
void VirtualRobot::Notice(core::MonoTime at) {
  if (noticed_) return;
  noticed_ = true;
  wake_ = std::min(wake_, at + Latency(kLoopWake_s, kLoopWakeMean_s));
}

void VirtualRobot::Step(core::MonoTime now) {
  now_ = now;
  while (!packets_.empty() && packets_.begin()->first <= now) {
    world_.emit("PHASE1", packets_.begin()->second, now);
    packets_.erase(packets_.begin());
  }
  if (now >= next_system_clock_) PostSystemClock(now);
  if (now >= next_second_) EverySecond(now);
  if (world_.gps.waiting() > 0 || world_.ahrs.waiting() > 0) Notice(now);
  if (!inbox_.empty() && inbox_.begin()->first <= now) Notice(inbox_.begin()->first);
  if (now >= wake_) Run(now);
}

/// One turn of the real-time loop (RtLoop::Run).
void VirtualRobot::Run(core::MonoTime now) {
  noticed_ = false;
  if (now >= deadline_) Consume(onboard::InputKind::kTick, now, {});
  ServicePort(gps_, onboard::InputKind::kGpsBytes, now);
  ServicePort(ahrs_, onboard::InputKind::kAhrsBytes, now);
  TakeInbox(now);
  deadline_ = core_->NextDeadline(now);
  wake_ = deadline_ + Latency(kLoopWake_s, kLoopWakeMean_s);
}

void VirtualRobot::ServicePort(VirtualLink& link, onboard::InputKind kind, core::MonoTime now) {
  link.Service(now, [this, now](const onboard::PortNote& note) {
    const auto bytes = onboard::Pack(note);
    Consume(onboard::InputKind::kPort, now, onboard::BytesOf(bytes.view()));
  });
  for (auto bytes = link.Read(now); !bytes.empty(); bytes = link.Read(now)) {
    Consume(kind, link.first_byte(), bytes);
  }
}

void VirtualRobot::TakeInbox(core::MonoTime now) {
  while (!inbox_.empty() && inbox_.begin()->first <= now) {
    Item item = std::move(inbox_.begin()->second);
    inbox_.erase(inbox_.begin());
    if (item.frame) {
      item.frame->sequence = ++sequence_;
      core_->OnFrame(*item.frame);
    } else {
      Consume(item.kind, item.mono, item.bytes);
    }
  }
}

void VirtualRobot::Consume(onboard::InputKind kind, core::MonoTime mono,
                           std::span<const std::uint8_t> bytes) {
  core_->OnInput({kind, ++sequence_, mono, bytes});
}

void VirtualRobot::PostSystemClock(core::MonoTime now) {
  next_system_clock_ = now + kSystemClockPeriod;
  const std::int64_t utc_ns = world_.utc_at(now).ns();
  std::vector<std::uint8_t> bytes(sizeof(utc_ns));
  std::memcpy(bytes.data(), &utc_ns, sizeof(utc_ns));
  Post(now + Latency(kThreadWake_s, kThreadWakeMean_s), {.kind = onboard::InputKind::kSystemClock,
                                                         .mono = now,
                                                         .bytes = std::move(bytes),
                                                         .frame = {}});
}

void VirtualRobot::EverySecond(core::MonoTime now) {
  next_second_ = now + core::Seconds(1);
  world_.emit("COUNTERS", onboard::CountersMessage(counters_, now), now);
}

void VirtualRobot::Finish(core::MonoTime now) {
  now_ = now;
  EverySecond(now);
}

}  // namespace kawara::sim
