#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/counters.hpp"
#include "drivers/v4l2_camera.hpp"

/// The kernel's test camera, and the driver on it: what the tests in the virtual machine share. All
/// waiting is for a condition, with deadlines that only a broken driver meets: the machine is
/// emulated and slow.
namespace kawara::drivers {

constexpr const char* kVivid = "/dev/video0";
constexpr const char* kVividOutput = "/dev/video1";
constexpr const char* kVividPlanes = "/dev/video2";
constexpr core::Duration kLong = core::Seconds(60);

/// A second opening of the camera, through which its faults are ordered.
inline void Order(const std::string& control, const std::string& value,
                  const std::string& path = kVivid) {
  V4l2Finder finder(path, OpenV4l2Node);
  const auto device = finder.Find();
  ASSERT_TRUE(device) << device.error().message;
  const auto controls = V4l2Controls::Read(*device);
  ASSERT_TRUE(controls) << controls.error().message;
  const auto set = controls->Set(control, value);
  ASSERT_TRUE(set) << set.error().message;
}

/// Small and quick, the way the emulated processor likes it.
inline V4l2CameraConfig SmallConfig(const std::string& format = "YUYV") {
  V4l2CameraConfig config;
  config.device = kVivid;
  config.mode = {320, 180, 10.0, format};
  return config;
}

/// A camera with its counters.
class Watched {
 public:
  explicit Watched(const V4l2CameraConfig& config) : camera_(config, counters_) {}

  V4l2Camera& camera() { return camera_; }
  std::int64_t Count(const std::string& name) {
    return counters_.Register("camera.v4l2." + name).value();
  }
  /// The next frame, whatever trouble comes before it; the last trouble is kept.
  std::shared_ptr<const Frame> Next(core::Duration patience = kLong) {
    const core::MonoTime end = core::MonoNow() + patience;
    while (core::MonoNow() < end) {
      const auto frame = camera_.Next(core::Milliseconds(200));
      if (frame && *frame) return *frame;
      if (frame) continue;
      trouble_ = frame.error().message;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    ADD_FAILURE() << "no frame for a long time; last trouble: " << trouble_;
    return nullptr;
  }
  /// Frames until this many have come or `done`.
  int Frames(
      int count, const std::function<bool()>& done = [] { return false; }) {
    int n = 0;
    while (n < count && !done()) {
      if (Next() == nullptr) return n;
      ++n;
    }
    return n;
  }
  /// Calls Next() until it fails; what it said.
  core::Error Trouble(core::Duration patience = kLong) {
    const core::MonoTime end = core::MonoNow() + patience;
    while (core::MonoNow() < end) {
      const auto frame = camera_.Next(core::Milliseconds(200));
      if (!frame) return frame.error();
    }
    ADD_FAILURE() << "no trouble came";
    return {core::ErrorCode::kTimeout, ""};
  }
  const std::string& trouble() const { return trouble_; }

 private:
  core::Counters counters_;
  V4l2Camera camera_;
  std::string trouble_;
};

inline void WriteSys(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  ASSERT_TRUE(file) << path;
}
inline void Unplug() { WriteSys("/sys/bus/platform/drivers/vivid/unbind", "vivid.0"); }
inline void Replug() { WriteSys("/sys/bus/platform/drivers/vivid/bind", "vivid.0"); }

}  // namespace kawara::drivers
