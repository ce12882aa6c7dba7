#include "drivers/sick.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include "core/geodesy.hpp"

namespace kawara::drivers {
namespace {

constexpr std::uint8_t kFromScanner = 0x80;
constexpr std::uint8_t kScanReply = 0xB0;
constexpr std::uint8_t kRangeReply =
    0xB7;                                ///< part of a scan: two more words, first and last value
constexpr std::size_t kHeaderBytes = 4;  ///< STX, address, length

std::uint16_t LittleEndian(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | (bytes[at + 1] << 8));
}

/// Count, unit and values in a telegram's payload begin here (after the command).
constexpr std::size_t CountAt(std::uint8_t command) { return command == kRangeReply ? 5 : 1; }

/// Number of values, if the payload (command to status, `length` bytes) has room for just them. The
/// count is the word's low 10 bits (sicktoolbox); above them an LMS puts the partial-scan number.
/// An LMS set up to number its telegrams and turns sends one or two more bytes before the status.
std::optional<std::size_t> ScanPoints(std::uint8_t command, std::size_t length,
                                      std::uint16_t count_word) {
  const std::size_t points = count_word & 0x03FFU;
  const std::size_t least = CountAt(command) + 2 + 2 * points + 1;
  if (length < least || length > least + 2) return std::nullopt;
  return points;
}

bool IsScan(std::uint8_t command) { return command == kScanReply || command == kRangeReply; }

}  // namespace

SickConfig SickConfig::Pls101() { return {}; }

SickConfig SickConfig::Lms2xx() {
  SickConfig config;
  config.format = SerialFormat::k8N1;
  config.password = "SICK_LMS";
  config.mirror_period = core::Duration(13'333'333);
  return config;
}

core::Duration SickConfig::ByteTime() const {
  const std::int64_t bits = format == SerialFormat::k8N1 ? 10 : 11;
  return core::Duration(bits * 1'000'000'000 / std::max(baud_bps, 1));
}

core::MonoTime SickScan::BeamTime(std::size_t i) const {
  // The mirror turns once in mirror_period, so half of it sweeps pi; mid_sweep is at pi/2.
  const double turns = (AngleRad(i) - core::kPi / 2.0) / (2.0 * core::kPi);
  return mid_sweep + core::DurationFromSeconds(turns * core::ToSeconds(mirror_period));
}

SickDecoder::SickDecoder(const SickConfig& config) : config_(config), buffer_(config.ByteTime()) {}

void SickDecoder::Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes,
                       SickSink& sink) {
  std::size_t taken = 0;
  while (taken < bytes.size()) {
    const core::MonoTime stamp = arrival + static_cast<std::int64_t>(taken) * buffer_.byte_time();
    taken += buffer_.Append(stamp, bytes.subspan(taken));
    Parse(sink, false);
  }
}

void SickDecoder::Finish(SickSink& sink) {
  Parse(sink, true);
  Reset();
}

void SickDecoder::Reset() {
  stats_.skipped_bytes += buffer_.size();
  buffer_.Clear();
  in_step_ = true;
}

void SickDecoder::Skip(std::size_t n) {
  buffer_.Consume(n);
  stats_.skipped_bytes += n;
  in_step_ = false;
}

void SickDecoder::Parse(SickSink& sink, bool ended) {
  while (buffer_.size() > 0) {
    const auto data = buffer_.data();
    if (data[0] != kSickStx) {
      if (in_step_ && (data[0] == kSickAck || data[0] == kSickNak)) {
        const bool accepted = data[0] == kSickAck;
        ++(accepted ? stats_.acks : stats_.naks);
        sink.OnAcknowledge(buffer_.FrontStamp(), accepted);
        buffer_.Consume(1);
        continue;
      }
      const auto* found =
          static_cast<const std::uint8_t*>(std::memchr(data.data(), kSickStx, data.size()));
      Skip(found != nullptr ? static_cast<std::size_t>(found - data.data()) : data.size());
      continue;
    }
    std::size_t total = 0;
    switch (JudgeShape(data, total)) {
      case Shape::kNeedMore:
        if (!ended) return;
        Skip(1);
        break;
      case Shape::kNo:
        Skip(1);
        break;
      case Shape::kWhole:
        if (SickCrc(data.first(total - 2)) == LittleEndian(data, total - 2)) {
          Take(total, sink);
        } else {
          // Inside a damaged telegram much looks like a short one; those are no telegrams of their
          // own.
          if (in_step_ || IsScan(data[kHeaderBytes])) ++stats_.bad_checksum;
          Skip(1);
        }
        break;
    }
  }
}

/// Whether data, which begins with STX, can be a telegram, and of what size. Says no as early as it
/// can: a false start must not hold back the telegrams behind it.
SickDecoder::Shape SickDecoder::JudgeShape(std::span<const std::uint8_t> data,
                                           std::size_t& total) const {
  if (data.size() < 2) return Shape::kNeedMore;
  const bool from_scanner = data[1] == (config_.address | kFromScanner);
  const bool to_scanner = config_.decode_requests && data[1] == config_.address;
  if (!from_scanner && !to_scanner) return Shape::kNo;
  if (data.size() < kHeaderBytes) return Shape::kNeedMore;
  const std::size_t length = LittleEndian(data, 2);
  if (length < 1 || length > kSickMaxLength) return Shape::kNo;
  if (data.size() < kHeaderBytes + 1) return Shape::kNeedMore;
  const std::uint8_t command = data[kHeaderBytes];
  // Replies are requests + 0x80; 0x90 to 0x92 have that bit, too.
  if (from_scanner != ((command & kFromScanner) != 0)) return Shape::kNo;
  if (from_scanner && IsScan(command)) {
    const std::size_t count_at = kHeaderBytes + CountAt(command);
    if (data.size() < count_at + 2) return Shape::kNeedMore;
    if (!ScanPoints(command, length, LittleEndian(data, count_at))) return Shape::kNo;
  }
  total = length + kSickOverheadBytes;
  return data.size() < total ? Shape::kNeedMore : Shape::kWhole;
}

void SickDecoder::Take(std::size_t total, SickSink& sink) {
  const auto telegram = buffer_.data().first(total);
  SickMessage message;
  message.arrival = buffer_.FrontStamp();
  message.address = telegram[1];
  message.command = telegram[kHeaderBytes];
  message.telegram = telegram;
  message.data = telegram.subspan(kHeaderBytes + 1, total - kSickOverheadBytes - 1);
  ++stats_.telegrams;
  stats_.telegram_bytes += total;
  sink.OnMessage(message);
  if (message.FromScanner() && IsScan(message.command)) TakeScan(message, sink);
  buffer_.Consume(total);
  in_step_ = true;
}

void SickDecoder::TakeScan(const SickMessage& message, SickSink& sink) {
  const auto payload = message.telegram.subspan(kHeaderBytes);
  const std::size_t count_at = CountAt(message.command);
  const std::uint16_t count_word = LittleEndian(payload, count_at);
  const std::size_t length = LittleEndian(message.telegram, 2);
  const auto points = ScanPoints(message.command, length, count_word);
  constexpr std::array<double, 3> kMetresPerCount{0.01, 0.001, 0.1};
  const std::size_t unit = count_word >> 14;
  if (!points || unit >= kMetresPerCount.size()) {
    ++stats_.bad_scans;
    return;
  }
  scan_.arrival = message.arrival;
  scan_.mirror_period = config_.mirror_period;
  scan_.mid_sweep = message.arrival - config_.output_delay - config_.mirror_period / 4;
  scan_.metres_per_count = kMetresPerCount[unit];
  scan_.command = message.command;
  scan_.partial_index = static_cast<std::uint8_t>((count_word >> 11) & 0x03U);
  scan_.status = message.data.back();
  scan_.range_bits = config_.range_bits;
  scan_.size = *points;
  SetAngles(payload);
  for (std::size_t i = 0; i < *points; ++i) {
    scan_.words[i] = LittleEndian(payload, count_at + 2 + 2 * i);
  }
  ++stats_.scans;
  sink.OnScan(scan_);
}

/// The number of values tells sweep and step: 180 deg in steps of 1 or 0.5, 100 deg (40..140) in
/// steps of 1, 0.5 or 0.25.
void SickDecoder::SetAngles(std::span<const std::uint8_t> payload) {
  double first_deg = 0.0;
  double step_deg = 0.0;
  switch (scan_.size) {
    case 181:
      step_deg = 1.0;
      break;
    case 361:
      step_deg = 0.5;
      break;
    case 101:
      first_deg = 40.0;
      step_deg = 1.0;
      break;
    case 201:
      first_deg = 40.0;
      step_deg = 0.5;
      break;
    case 401:
      first_deg = 40.0;
      step_deg = 0.25;
      break;
    default:
      break;
  }
  if (scan_.command == kRangeReply) {
    // Sent by the PLS in half degrees only; values are counted from 1.
    const std::uint16_t first = LittleEndian(payload, 1);
    step_deg = 0.5;
    first_deg = first > 0 ? (first - 1) * step_deg : 0.0;
  }
  scan_.first_angle_rad = (first_deg + 0.25 * scan_.partial_index) * core::kRadFromDeg;
  scan_.step_rad = step_deg * core::kRadFromDeg;
}

}  // namespace kawara::drivers
