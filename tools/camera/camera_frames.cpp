#include "tools/camera/camera_frames.hpp"

#include <cstdio>
#include <thread>

namespace kawara::tools {
namespace {

constexpr core::Duration kWait = core::Milliseconds(200);

bool MayPass(core::ErrorCode code) {
  return code == core::ErrorCode::kUnavailable || code == core::ErrorCode::kTimeout ||
         code == core::ErrorCode::kIo;
}

}  // namespace

core::Expected<void> ForFrames(drivers::V4l2Camera& camera, core::Duration patience,
                               const std::function<bool(const drivers::Frame&)>& take) {
  core::MonoTime last = core::MonoNow();
  std::string trouble;
  bool ever = false;
  for (;;) {
    const auto frame = camera.Next(kWait);
    if (frame && *frame) {
      if (!trouble.empty()) std::fprintf(stderr, "%s\n", camera.Description().c_str());
      trouble.clear();
      last = core::MonoNow();
      ever = true;
      if (!take(**frame)) return {};
      continue;
    }
    if (!frame) {
      // A device that was there and has no node now may get it back.
      const bool gone = ever && frame.error().code == core::ErrorCode::kNotFound;
      if (!MayPass(frame.error().code) && !gone) return tl::unexpected(frame.error());
      if (trouble.empty()) std::fprintf(stderr, "%s\n", frame.error().message.c_str());
      trouble = frame.error().message;
      std::this_thread::sleep_for(kWait);
    }
    if (core::MonoNow() - last > patience) {
      char text[64];
      std::snprintf(text, sizeof text, "no frame for %.1f s", core::ToSeconds(patience));
      return core::Fail(
          core::ErrorCode::kTimeout,
          text + (trouble.empty() ? std::string(" (is it triggered by a wire?)") : ": " + trouble));
    }
  }
}

}  // namespace kawara::tools
