#include "onboard/correction_source.hpp"

#include <poll.h>

#include <algorithm>
#include <array>

#include "drivers/reconnecting_port.hpp"
#include "onboard/realtime.hpp"

namespace kawara::onboard {
namespace {

constexpr core::Duration kNap = core::Milliseconds(200);
/// What the inbox takes as one input.
constexpr std::size_t kChunkBytes = 1024;

}  // namespace

drivers::NtripClientConfig NtripConfigOf(const CorrectionsConfig& config) {
  drivers::NtripClientConfig client;
  client.caster.host = config.host;
  client.caster.port = static_cast<std::uint16_t>(config.port);
  client.caster.mountpoint = config.mountpoint;
  client.caster.user = config.user;
  client.caster.password = config.password;
  client.caster.version = config.ntrip_version;
  return client;
}

CorrectionSource::CorrectionSource(const CorrectionsConfig& config, InputInbox& inbox)
    : config_(config), inbox_(inbox) {
  if (config_.source == "ntrip") thread_ = std::thread([this] { RunNtrip(); });
  if (config_.source == "serial") thread_ = std::thread([this] { RunSerial(); });
}

CorrectionSource::~CorrectionSource() { Stop(); }

void CorrectionSource::Stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void CorrectionSource::RunNtrip() {
  BecomeBackground("corrections", 0);
  core::Events events;
  drivers::NtripClient client(
      NtripConfigOf(config_), events,
      [this](core::MonoTime now, std::span<const std::uint8_t> bytes) { Post(now, bytes); });
  std::uint64_t streams = 0;
  while (!stopping_.load(std::memory_order_relaxed)) {
    client.Wait(core::MonoNow(), kNap);
    core::GnssFix fix;
    while (fixes_.TryPop(fix)) client.OnFix(fix);
    client.Service(core::MonoNow());
    if (client.stats().streams != streams) {
      streams = client.stats().streams;
      Post(core::MonoNow(), {});  // a new stream: a frame begun in the old one is void
    }
    TellEvents(events);
  }
}

void CorrectionSource::RunSerial() {
  BecomeBackground("corrections", 0);
  drivers::ReconnectConfig port_config;
  port_config.serial.device = config_.device;
  port_config.serial.baud_bps = config_.baud_bps;
  drivers::ReconnectingPort port(port_config);
  std::array<std::uint8_t, kChunkBytes> buffer{};
  while (!stopping_.load(std::memory_order_relaxed)) {
    pollfd fd{port.fd(), POLLIN, 0};
    (void)poll(&fd, 1, static_cast<int>(kNap / core::Milliseconds(1)));
    const core::MonoTime now = core::MonoNow();
    port.Service(now);
    while (const std::size_t n = port.Read(now, buffer)) Post(now, {buffer.data(), n});
    drivers::PortEvent event;
    while (port.TryPopEvent(event)) {
      if (event.kind == drivers::PortEventKind::kOpened) Post(now, {});
      const bool good = event.kind == drivers::PortEventKind::kOpened ||
                        event.kind == drivers::PortEventKind::kTalking;
      const NoteBytes bytes =
          Pack(EventNote{good ? core::Severity::kInfo : core::Severity::kWarnHigh,
                         "corrections.port", event.text.view()});
      inbox_.Post(InputKind::kNote, event.stamp, BytesOf(bytes.view()));
    }
  }
}

void CorrectionSource::Post(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) {
    inbox_.Post(InputKind::kCorrectionBytes, now, bytes);
    return;
  }
  while (!bytes.empty()) {
    const std::size_t n = std::min(bytes.size(), kChunkBytes);
    inbox_.Post(InputKind::kCorrectionBytes, now, bytes.first(n));
    bytes = bytes.subspan(n);
  }
}

void CorrectionSource::TellEvents(core::Events& events) {
  core::Event event;
  while (events.TryPop(event)) {
    const NoteBytes bytes = Pack(EventNote{event.severity, event.name, event.text.view()});
    inbox_.Post(InputKind::kNote, event.stamp, BytesOf(bytes.view()));
  }
}

}  // namespace kawara::onboard
