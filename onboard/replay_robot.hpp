#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "comms/event_log_reader.hpp"
#include "core/expected.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

struct ReplayStats {
  std::int64_t inputs = 0;
  std::int64_t frames = 0;
  std::int64_t frames_without_pixels = 0;  ///< given up on a full disk, or destroyed
  std::int64_t fixes = 0;
  std::int64_t poses = 0;
  std::int64_t previews = 0;
  std::int64_t pictures = 0;
  std::int64_t events = 0;
};

/// The robot again, from its log: the recorded inputs go through the same core in the same order,
/// the pictures are made on this thread, what the recorder said of itself is passed on. As fast as
/// the computer can; the same log gives the same messages, byte for byte, every time.
class ReplayRobot {
 public:
  /// Gets every message but the inputs themselves, with the time of the log entry that caused it.
  using Emit = std::function<void(std::string_view channel, std::span<const std::uint8_t> bytes,
                                  std::int64_t time_utc_us)>;

  /// Configuration of the recording, from its CONFIG event. kFormat: there is none, or not of
  /// kawara-onboard.
  static core::Expected<OnboardConfig> RecordedConfig(comms::EventLogReader& reader);

  /// Plays `reader` to its end. Errors: the picture configuration. Damage in the log costs what it
  /// hit and is in reader.stats().
  static core::Expected<ReplayStats> Play(comms::EventLogReader& reader,
                                          const OnboardConfig& config, const Emit& emit);
};

}  // namespace kawara::onboard
