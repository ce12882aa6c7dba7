#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/counters.hpp"
#include "drivers/camera.hpp"
#include "drivers/v4l2_session.hpp"
#include "drivers/v4l2_trigger.hpp"

namespace kawara::drivers {

/// A camera of the kernel's (V4L2): opened on demand by Next(), again after every loss, whatever
/// number its node has then; restarted when it hangs (first its stream, then the device). Frames
/// are copied out of the kernel's buffers, which go back at once, and then converted: MJPEG to JPEG
/// files, GREY to Grey8, all else to Rgb8. Frames the device marks as damaged, or that are cut off,
/// are left out and counted.
///
/// Trigger(): a camera that runs freely has nothing to do, and frame and trigger are paired by
/// time; with a trigger control the control is set, with a trigger line the line is pulsed, by a
/// thread of its own. A line that fails is opened anew, and Next() tells why while no frames come.
/// Threads as drivers::Camera says; counters may be read by anybody.
///
/// Counters: camera.v4l2.opened, .open_failures, .lost (unplugged, stream died), .restarts (it
/// hung), .sequence_gaps (frames the camera counted and we never saw), .error_frames (the device
/// marked them), .damaged_frames (cut off, or no picture), .foreign_stamps (not of
/// CLOCK_MONOTONIC), .trigger_failures.
class V4l2Camera final : public Camera {
 public:
  /// What the camera has of the machine around it; the tests have a scripted one.
  struct System {
    V4l2Opener open = OpenV4l2Node;
    V4l2Finder::Lister nodes = ListVideoNodes;
    std::function<core::MonoTime()> now = core::MonoNow;
    std::function<core::Expected<std::unique_ptr<TriggerLine>>(const TriggerLineConfig&)>
        open_line = OpenTriggerLine;
  };

  V4l2Camera(V4l2CameraConfig config, core::Counters& counters);
  V4l2Camera(V4l2CameraConfig config, core::Counters& counters, System system);
  ~V4l2Camera() override;
  V4l2Camera(const V4l2Camera&) = delete;
  V4l2Camera& operator=(const V4l2Camera&) = delete;

  core::Expected<void> Trigger(std::uint32_t sequence) override;
  /// Errors: kUnavailable (gone, hangs, busy: worth another try), kInvalidArgument and kNotFound
  /// (the configuration asks for what the camera does not have; said again at every try).
  core::Expected<std::shared_ptr<const Frame>> Next(core::Duration timeout) override;
  std::string Description() const override { return description_; }

  /// Sets controls of the open camera; a length of exposure among them is that of frames that begin
  /// later. kUnavailable: it is not open. Camera thread only.
  core::Expected<void> Set(const V4l2Settings& settings);
  /// Null: not open. Camera thread only.
  V4l2Session* session() { return session_.get(); }

 private:
  struct Tally;
  using Answer = core::Expected<std::shared_ptr<const Frame>>;

  core::Expected<void> Open();
  tl::unexpected<core::Error> Lose(core::Error why);
  Answer Hang(core::Duration silence);
  bool IsSilent(core::MonoTime now) const;
  core::MonoTime SilentSince() const;
  /// Copies and gives back; null: the frame is left out.
  core::Expected<std::shared_ptr<Frame>> Receive(const V4l2Loan& loan);
  void StampExposure(const V4l2Loan& loan, Frame& frame);
  bool FillPicture(Frame& frame) const;
  void CountGap(std::uint32_t sequence);
  void PullTrigger();
  core::Expected<void> PullLine();
  core::Expected<void> PullControl();
  std::string UnansweredText() const;

  V4l2CameraConfig config_;
  std::unique_ptr<Tally> tally_;
  std::function<core::MonoTime()> now_;
  V4l2Finder finder_;
  std::unique_ptr<V4l2Session> session_;
  std::mutex session_mutex_;  ///< session_ against the trigger thread, which uses its controls
  V4l2StampClock stamps_;
  V4l2StampRule rule_;
  struct NextExposure {
    core::MonoTime set;  ///< of frames that begin after this
    core::Duration length{};
  };
  std::optional<NextExposure> next_exposure_;
  std::string description_;
  std::vector<std::uint8_t> copy_;
  std::optional<std::uint32_t> last_sequence_;
  core::Duration hang_{};     ///< of this session
  core::MonoTime last_life_;  ///< last frame, or opening or restart
  bool restarted_ = false;    ///< and no frame since
  core::MonoTime next_try_;
  std::optional<core::Error> trouble_;  ///< why it is closed
  decltype(System::open_line) open_line_;
  std::unique_ptr<TriggerLine> line_;           ///< trigger thread only
  std::optional<core::Error> trigger_trouble_;  ///< session_mutex_
  std::atomic<int> unanswered_{0};              ///< triggers since the last frame
  bool answered_ = false;                       ///< a frame has come since the opening
  std::atomic<bool> open_{false};
  std::atomic<std::int64_t> unanswered_ns_{0};  ///< first trigger since the last frame; 0: none
  std::unique_ptr<V4l2TriggerThread> trigger_;  ///< last: its thread uses the rest
};

}  // namespace kawara::drivers
