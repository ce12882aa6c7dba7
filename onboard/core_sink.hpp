#pragma once
#include <cstdint>
#include <span>

#include "core/events.hpp"
#include "core/measurements.hpp"
#include "estimation/gps_timeline.hpp"
#include "estimation/navigation_report.hpp"
#include "onboard/epoch_scheduler.hpp"
#include "onboard/input.hpp"

namespace kawara::onboard {

/// A frame that was selected: the picture can be made at once, its pose follows as ExposurePose of
/// the same epoch.
struct PictureOrder {
  std::int64_t epoch = 0;  ///< exposures with a frame, counted from 1 in the mission
  std::uint32_t slot = 0;  ///< FrameInput.slot
};

/// The pose of a picture's exposure, once the measurements around it are in.
struct ExposurePose {
  std::int64_t epoch = 0;
  PictureReason reason = PictureReason::kEveryEpochs;
  core::Pose body;    ///< of the body's reference point, at mid-exposure
  core::Pose camera;  ///< of the camera's centre
  std::int32_t gps_minus_utc_s = 0;
  double geoid_separation_m = 0.0;  ///< NaN unknown
  double hdop = 0.0;                ///< NaN unknown
};

/// What the robot's core has to say. Live the calls come on the real-time thread (no allocation, no
/// lock, no I/O in them); in replay on the caller's. Only Trigger, Write and SetBaud act on the
/// world.
class CoreSink {
 public:
  virtual ~CoreSink() = default;
  /// An input as consumed: what a log must hold to repeat everything else. Called before its
  /// effects.
  virtual void OnInput(const Input& input) = 0;
  virtual void OnFrame(const FrameInput& frame, bool selected) = 0;

  virtual void OnFix(const core::GnssFix& fix) = 0;
  virtual void OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) = 0;
  virtual void OnPose(const core::Pose& pose) = 0;
  virtual void OnNavigation(const estimation::NavigationReport& report) = 0;
  virtual void OnClock(const estimation::ClockStatus& clock) = 0;
  virtual void OnEvent(const core::Event& event, core::GpsTime time) = 0;
  virtual void OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) = 0;
  virtual void OnPicture(const PictureOrder& order) = 0;
  virtual void OnExposurePose(const ExposurePose& pose) = 0;

  virtual void Trigger(std::uint32_t sequence) = 0;
  virtual void Write(PortId port, std::span<const std::uint8_t> bytes) = 0;
  virtual void SetBaud(PortId port, int baud_bps) = 0;
};

}  // namespace kawara::onboard
