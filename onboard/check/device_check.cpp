#include "onboard/check/device_check.hpp"

#include <poll.h>

#include <array>
#include <string>

#include "core/counters.hpp"
#include "drivers/serial_port.hpp"
#include "onboard/camera_source.hpp"
#include "onboard/correction_source.hpp"
#include "onboard/pps_source.hpp"

namespace kawara::onboard {
namespace {

constexpr core::Duration kListen = core::Milliseconds(2500);
/// For a name to be resolved, a connection made and an answer given.
constexpr core::Duration kAnswer = core::Seconds(5);

/// Bytes that come of themselves within kListen.
std::size_t Listen(drivers::SerialPort& port) {
  std::array<std::uint8_t, 4096> buffer{};
  std::size_t bytes = 0;
  const core::MonoTime end = core::MonoNow() + kListen;
  while (bytes < 64 && core::MonoNow() < end) {
    pollfd wait{port.fd(), POLLIN, 0};
    (void)poll(&wait, 1, 100);
    const auto n = port.Read(buffer);
    if (!n) break;
    bytes += *n;
  }
  return bytes;
}

Finding CheckSerial(const std::string& name, const std::string& device, int baud_bps,
                    bool talks_first) {
  const std::string subject = name + " " + device;
  drivers::SerialConfig config;
  config.device = device;
  config.baud_bps = baud_bps;
  auto port = drivers::SerialPort::Open(config);
  if (!port) return Wrong(subject, port.error().message);
  const std::size_t bytes = Listen(*port);
  if (bytes > 0) return Good(subject, "opens and speaks");
  // A receiver that was never set up is silent until the robot asks.
  if (!talks_first) {
    return Good(subject, "opens; silent until it is set up, which the robot does");
  }
  return Weak(subject, "opens, but nothing comes at " + std::to_string(baud_bps) +
                           " baud: power, cable, rate?");
}

Finding CheckCamera(const OnboardConfig& config) {
  const CameraConfig& camera = config.camera;
  const std::string subject =
      "camera " + (camera.source == "v4l2" ? camera.v4l2.device : camera.path);
  core::Counters counters;
  const CameraSource source = MakeCamera(config, counters);
  const core::MonoTime end = core::MonoNow() + kListen;
  for (;;) {
    const auto frame = source.camera->Next(core::Milliseconds(200));
    if (!frame) return Wrong(subject, frame.error().message);
    if (*frame) {
      return Good(subject, "sends pictures: " + source.camera->Description());
    }
    if (core::MonoNow() < end) continue;
    if (!camera.RunsFreely()) {
      return Good(subject,
                  "answers; a triggered camera sends nothing yet. " + source.camera->Description());
    }
    return Wrong(subject, "opens, but no picture comes");
  }
}

Finding CheckPulse(const PpsSettings& settings) {
  const std::string subject = "pulse " + settings.device;
  const auto pps = MakePps(settings);
  const core::MonoTime end = core::MonoNow() + kListen;
  int edges = 0;
  while (core::MonoNow() < end) {
    const auto edge = pps->Next(core::Milliseconds(200));
    if (!edge) return Wrong(subject, edge.error().message);
    if (*edge) ++edges;
  }
  if (edges == 0) {
    return Weak(subject,
                "is there, but no pulse in 2.5 s: cable, receiver's PPS setting, gps.pps.edge?");
  }
  if (edges > 3) {
    return Weak(subject, std::to_string(edges) +
                             " pulses in 2.5 s, not one a second: the receiver's PPS setting?");
  }
  return Good(subject, "comes");
}

/// The caster's stream, asked for as the robot does.
Finding CheckCaster(const CorrectionsConfig& corrections) {
  const std::string subject =
      "corrections " + corrections.host + ":" + std::to_string(corrections.port);
  core::Events events;
  std::size_t bytes = 0;
  drivers::NtripClient client(
      NtripConfigOf(corrections), events,
      [&](core::MonoTime, std::span<const std::uint8_t> some) { bytes += some.size(); });
  const core::MonoTime end = core::MonoNow() + kAnswer;
  while (core::MonoNow() < end && bytes == 0) {
    client.Service(core::MonoNow());
    if (client.stats().failures > 0) return Wrong(subject, client.last_error());
    client.Wait(core::MonoNow(), core::Milliseconds(100));
  }
  if (bytes > 0) return Good(subject, "stream " + corrections.mountpoint + " comes");
  if (client.stats().streams > 0) {
    return Weak(subject,
                "answers, but nothing comes in 5 s; a network's virtual station begins "
                "when the robot has a position, else: does its base send?");
  }
  return Weak(subject, "no answer in 5 s: address, port, network?");
}

}  // namespace

Findings CheckDevices(const OnboardConfig& config) {
  Findings findings;
  findings.push_back(
      CheckSerial("gps", config.gps.device, config.gps.baud_bps, !config.gps.configure));
  findings.push_back(CheckSerial("ahrs", config.ahrs.device, config.ahrs.baud_bps, false));
  if (config.corrections.source == "serial") {
    findings.push_back(
        CheckSerial("corrections", config.corrections.device, config.corrections.baud_bps, true));
  }
  if (config.corrections.source == "ntrip") findings.push_back(CheckCaster(config.corrections));
  if (config.camera.source != "none") findings.push_back(CheckCamera(config));
  if (!config.gps.pps.device.empty()) findings.push_back(CheckPulse(config.gps.pps));
  return findings;
}

}  // namespace kawara::onboard
