#include "onboard/camera_reader.hpp"

#include <string>

#include "onboard/realtime.hpp"

namespace kawara::onboard {

CameraReader::CameraReader(drivers::Camera& camera, FrameTable& frames, InputInbox& inbox,
                           core::Counters& counters)
    : camera_(camera),
      frames_(frames),
      inbox_(inbox),
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
      if (!was_up_) Tell(true, core::Severity::kInfo, "the camera is there");
      if (*frame != nullptr) Take(*frame);
      continue;
    }
    if (was_up_ || !was_told_) Tell(false, core::Severity::kWarnHigh, frame.error().message);
    // The next call tries to connect again; not in a tight loop.
    std::this_thread::sleep_for(core::Milliseconds(200));
  }
}

void CameraReader::Take(const std::shared_ptr<const drivers::Frame>& frame) {
  frames_counter_.Add();
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

void CameraReader::Tell(bool open, core::Severity severity, std::string_view text) {
  was_up_ = open;
  was_told_ = true;
  PortNote note;
  note.port = PortId::kCamera;
  note.open = open;
  note.changed = true;
  note.severity = severity;
  note.text = text;
  const NoteBytes bytes = Pack(note);
  inbox_.Post(InputKind::kPort, core::MonoNow(), BytesOf(bytes.view()));
}

}  // namespace kawara::onboard
