#include "onboard/camera_reader.hpp"

#include <utility>

#include "onboard/realtime.hpp"

namespace kawara::onboard {

CameraReader::CameraReader(drivers::Camera& camera, FrameTable& frames, InputInbox& inbox,
                           core::Counters& counters, Watch watch)
    : camera_(camera),
      frames_(frames),
      inbox_(inbox),
      teller_(inbox, PortId::kCamera, "the camera is there"),
      watch_(std::move(watch)),
      frames_counter_(counters.Register("camera.frames")),
      no_slot_(counters.Register("camera.frames_without_slot")),
      thread_([this] { Run(); }) {}

CameraReader::~CameraReader() { Stop(); }

void CameraReader::Stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void CameraReader::Run() {
  BecomeBackground("camera", 0);
  while (!stopping_.load(std::memory_order_relaxed)) {
    const auto frame = camera_.Next(core::Milliseconds(200));
    if (frame) {
      teller_.Up(camera_.Description());
      if (*frame == nullptr) continue;
      if (watch_) watch_(**frame);
      Take(*frame);
      continue;
    }
    teller_.Down(frame.error().message);
    // The next call tries to connect again; not in a tight loop.
    std::this_thread::sleep_for(core::Milliseconds(200));
  }
}

/// Ahead of the frame that is the first to be exposed so.
void CameraReader::TellShutter(const drivers::Frame& frame) {
  if (frame.exposure.count() == 0 || frame.exposure == shutter_) return;
  if (inbox_.Post(InputKind::kShutter, frame.arrival, Pack(frame.exposure))) {
    shutter_ = frame.exposure;
  }
}

void CameraReader::Take(const std::shared_ptr<const drivers::Frame>& frame) {
  frames_counter_.Add();
  TellShutter(*frame);
  const auto slot = frames_.Put(frame);
  if (!slot) return no_slot_.Add();
  FrameInput input;
  input.slot = *slot;
  input.frame_sequence = frame->sequence;
  input.trigger_sequence = frame->trigger_sequence;
  input.exposure_start = frame->exposure_start;
  input.arrival = frame->arrival;
  if (!inbox_.PostFrame(input)) frames_.Release(*slot);
}

}  // namespace kawara::onboard
