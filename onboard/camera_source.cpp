#include "onboard/camera_source.hpp"

#include "drivers/camera_socket_client.hpp"
#include "drivers/v4l2_camera.hpp"
#include "onboard/exposure_keeper.hpp"

namespace kawara::onboard {

namespace {

drivers::TriggerLineConfig LineOf(const TriggerSection& trigger) {
  using Kind = drivers::TriggerLineConfig::Kind;
  drivers::TriggerLineConfig line;
  if (trigger.by == "gpio") line.kind = Kind::kGpio;
  if (trigger.by == "rts") line.kind = Kind::kRts;
  if (trigger.by == "dtr") line.kind = Kind::kDtr;
  line.device = trigger.device;
  line.line = trigger.line;
  line.active_low = trigger.active_low;
  line.pulse = core::DurationFromSeconds(trigger.pulse_s);
  return line;
}

}  // namespace

drivers::V4l2CameraConfig V4l2ConfigOf(const CameraConfig& camera) {
  const V4l2Section& section = camera.v4l2;
  drivers::V4l2CameraConfig config;
  config.device = section.device;
  config.mode.width_px = static_cast<std::uint32_t>(section.width_px);
  config.mode.height_px = static_cast<std::uint32_t>(section.height_px);
  config.mode.rate_hz = section.rate_hz;
  if (section.format != "auto") config.mode.format = section.format;
  config.controls = section.controls;
  config.stamps.exposure = core::DurationFromSeconds(camera.exposure_s);
  config.stamps.readout = core::DurationFromSeconds(section.readout_s);
  config.hang = core::DurationFromSeconds(section.hang_s);
  config.reconnect = core::DurationFromSeconds(section.reconnect_s);
  config.trigger_control = section.trigger.by == "control" ? section.trigger.control : "";
  config.trigger_line = LineOf(section.trigger);
  return config;
}

CameraSource MakeCamera(const OnboardConfig& config, core::Counters& counters) {
  CameraSource source;
  if (config.camera.source == "socket") {
    source.camera = std::make_unique<drivers::SocketCamera>(config.camera.path);
  } else if (config.camera.source == "v4l2") {
    auto camera = std::make_unique<drivers::V4l2Camera>(V4l2ConfigOf(config.camera), counters);
    const ExposureSettings& exposure = config.camera.v4l2.auto_exposure;
    if (exposure.enabled) {
      auto keeper = std::make_shared<ExposureKeeper>(
          exposure, config.picture, counters,
          [&camera = *camera](const core::config::NamedTexts& controls) {
            return camera.Set(controls);
          });
      source.watch = [keeper](const drivers::Frame& frame) { keeper->OnFrame(frame); };
    }
    source.camera = std::move(camera);
  }
  return source;
}

}  // namespace kawara::onboard
