#include "drivers/v4l2_session.hpp"

#include <linux/videodev2.h>

#include <utility>

namespace kawara::drivers {
namespace {

/// The unit of V4L2_CID_EXPOSURE_ABSOLUTE.
constexpr core::Duration kExposureUnit = std::chrono::microseconds(100);

}  // namespace

core::Expected<std::unique_ptr<V4l2Session>> V4l2Session::Open(V4l2Finder& finder,
                                                               const V4l2CameraConfig& config) {
  auto device = finder.Find();
  if (!device) return tl::unexpected(device.error());
  std::unique_ptr<V4l2Session> session(new V4l2Session(std::move(*device)));
  V4l2Session& s = *session;

  const auto offers = s.device_.Offers();
  if (!offers) return tl::unexpected(offers.error());
  const auto mode = ChooseV4l2Mode(*offers, config.mode);
  if (!mode) {
    return core::Fail(mode.error().code, "camera " + s.device_.path() + " (" +
                                             s.device_.identity().card + ") " +
                                             mode.error().message);
  }
  const auto format = s.device_.SetMode(*mode);
  if (!format) return tl::unexpected(format.error());
  s.format_ = *format;
  s.interval_ = s.device_.Interval();

  auto controls = V4l2Controls::Read(s.device_);
  if (!controls) return tl::unexpected(controls.error());
  s.controls_ = std::move(*controls);
  if (auto set = s.controls_->Set(config.controls); !set) return tl::unexpected(set.error());
  if (!config.trigger_control.empty() && s.controls_->Find(config.trigger_control) == nullptr) {
    return tl::unexpected(s.controls_->Get(config.trigger_control).error());
  }

  auto stream = V4l2Stream::Start(s.device_);
  if (!stream) return tl::unexpected(stream.error());
  s.stream_.emplace(std::move(*stream));
  return session;
}

std::optional<core::Duration> V4l2Session::Exposure() const {
  const V4l2Control* exposure = nullptr;
  const V4l2Control* automatic = nullptr;
  for (const V4l2Control& control : controls_->all()) {
    if (control.id == V4L2_CID_EXPOSURE_ABSOLUTE) exposure = &control;
    if (control.id == V4L2_CID_EXPOSURE_AUTO) automatic = &control;
  }
  if (exposure == nullptr) return std::nullopt;
  if (automatic != nullptr) {
    const auto mode = controls_->Get(automatic->name);
    if (!mode || (*mode != V4L2_EXPOSURE_MANUAL && *mode != V4L2_EXPOSURE_SHUTTER_PRIORITY)) {
      return std::nullopt;
    }
  }
  const auto value = controls_->Get(exposure->name);
  if (!value) return std::nullopt;
  return *value * kExposureUnit;
}

std::string V4l2Session::Description() const {
  return device_.path() + ": " + device_.identity().card + " (" + device_.identity().bus_info +
         "), " + TextOf(V4l2Mode{format_.fourcc, format_.width_px, format_.height_px, interval_}) +
         ", " + std::to_string(stream_->buffers()) + " buffers";
}

}  // namespace kawara::drivers
