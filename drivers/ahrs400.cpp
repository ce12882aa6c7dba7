#include "drivers/ahrs400.hpp"

#include <algorithm>
#include <cstring>

namespace kawara::drivers {
namespace {

bool IsPrintable(std::uint8_t c) { return c >= 0x20 && c < 0x7F; }

}  // namespace

Ahrs400Decoder::Ahrs400Decoder(const Ahrs400Config& config)
    : config_(config), clock_(config.clock), buffer_(config.byte_time) {}

void Ahrs400Decoder::Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes,
                          Ahrs400Sink& sink) {
  std::size_t taken = 0;
  while (taken < bytes.size()) {
    const core::MonoTime stamp = arrival + static_cast<std::int64_t>(taken) * config_.byte_time;
    taken += buffer_.Append(stamp, bytes.subspan(taken));
    Parse(sink, false);
  }
}

void Ahrs400Decoder::Finish(Ahrs400Sink& sink) {
  Parse(sink, true);
  stats_.skipped_bytes += buffer_.size();
  buffer_.Clear();
  locked_ = false;
  grid_mode_.reset();
}

void Ahrs400Decoder::Reset() {
  stats_.skipped_bytes += buffer_.size();
  buffer_.Clear();
  clock_.Restart();
  locked_ = false;
  grid_mode_.reset();
  after_version_ = false;
  bytes_lost_ = false;
  has_last_ = false;
}

void Ahrs400Decoder::Skip(std::size_t n) {
  buffer_.Consume(n);
  stats_.skipped_bytes += n;
  locked_ = false;
  after_version_ = false;
  bytes_lost_ = true;
}

void Ahrs400Decoder::Parse(Ahrs400Sink& sink, bool ended) {
  while (buffer_.size() > 0) {
    const auto data = buffer_.data();
    if (data[0] != kAhrs400Header) {
      const void* header = std::memchr(data.data(), kAhrs400Header, data.size());
      const auto* found = static_cast<const std::uint8_t*>(header);
      Skip(found != nullptr ? static_cast<std::size_t>(found - data.data()) : data.size());
      continue;
    }
    if (const std::size_t hopeless = CountHopeless(data); hopeless > 0) {
      Skip(hopeless);
      continue;
    }
    const Judgement judgement = Judge(data, ended);
    switch (judgement.verdict) {
      case Verdict::kNeedMore:
        return;
      case Verdict::kNothing:
        Skip(1);
        break;
      case Verdict::kPacket:
        TakePacket(judgement.mode, sink);
        break;
      case Verdict::kVersion: {
        ++stats_.versions;
        std::array<char, kAhrs400VersionBytes - 2> text{};
        std::copy(data.begin() + 1, data.begin() + 1 + text.size(), text.begin());
        sink.OnVersion({text.data(), text.size()});
        buffer_.Consume(kAhrs400VersionBytes);
        after_version_ = true;
        break;
      }
      case Verdict::kSerial:
        ++stats_.serial_numbers;
        sink.OnSerialNumber(static_cast<std::uint32_t>(data[1]) << 24 |
                            static_cast<std::uint32_t>(data[2]) << 16 |
                            static_cast<std::uint32_t>(data[3]) << 8 | data[4]);
        buffer_.Consume(kAhrs400SerialBytes);
        after_version_ = false;
        break;
    }
  }
}

/// How many bytes at the front Judge would refuse one by one: a quick way through long runs of
/// header bytes.
std::size_t Ahrs400Decoder::CountHopeless(std::span<const std::uint8_t> data) const {
  const bool near_grid =
      grid_mode_ && buffer_.position() - grid_position_ <= kGridReach * PacketBytes(*grid_mode_);
  if (near_grid || after_version_) return 0;
  if (data.size() < kAhrs400AnglePacketBytes) return 0;
  // Sums of both payloads that would begin after data[n], carried along.
  constexpr std::size_t kShortEnd = kAhrs400ShortPacketBytes - 1;
  constexpr std::size_t kAngleEnd = kAhrs400AnglePacketBytes - 1;
  unsigned short_sum = Ahrs400Checksum(data.subspan(1, kShortEnd - 1));
  unsigned angle_sum = Ahrs400Checksum(data.subspan(1, kAngleEnd - 1));
  std::size_t n = 0;
  for (; n + kAhrs400AnglePacketBytes <= data.size(); ++n) {
    if (data[n] != kAhrs400Header || IsPrintable(data[n + 1]) ||
        (short_sum & 0xFFU) == data[n + kShortEnd] || (angle_sum & 0xFFU) == data[n + kAngleEnd]) {
      break;
    }
    short_sum += unsigned{data[n + kShortEnd]} - data[n + 1];
    angle_sum += unsigned{data[n + kAngleEnd]} - data[n + 1];
  }
  return n;
}

/// What begins at data[0], a header byte.
Ahrs400Decoder::Judgement Ahrs400Decoder::Judge(std::span<const std::uint8_t> data, bool ended) {
  if (data.size() >= kAhrs400VersionBytes) {
    if (IsPrintable(data[1]) && IsAhrs400Version(data.first(kAhrs400VersionBytes)))
      return {Verdict::kVersion, {}};
  } else if (data.size() >= 8 && !ended && std::all_of(data.begin() + 1, data.end(), IsPrintable)) {
    return {Verdict::kNeedMore, {}};
  }
  if (after_version_) {
    if (data.size() < kAhrs400SerialBytes && !ended) return {Verdict::kNeedMore, {}};
    if (data.size() >= kAhrs400SerialBytes && Ahrs400FrameFits(data.first(kAhrs400SerialBytes))) {
      return {Verdict::kSerial, {}};
    }
  }

  bool due_but_wrong = false;
  if (grid_mode_ && IsDue(PacketBytes(*grid_mode_))) {
    const std::size_t n = PacketBytes(*grid_mode_);
    if (data.size() >= n) {
      if (Ahrs400FrameFits(data.first(n))) return {Verdict::kPacket, *grid_mode_};
      due_but_wrong = true;
    } else if (!ended) {
      return {Verdict::kNeedMore, {}};
    }
  }

  const Ahrs400Mode short_mode =
      config_.mode == Ahrs400Mode::kVoltage ? Ahrs400Mode::kVoltage : Ahrs400Mode::kScaled;
  const std::array<Ahrs400Mode, 2> modes = config_.mode == Ahrs400Mode::kAngle
                                               ? std::array{Ahrs400Mode::kAngle, short_mode}
                                               : std::array{short_mode, Ahrs400Mode::kAngle};
  bool need_more = false;
  for (const Ahrs400Mode mode : modes) {
    if (mode != modes[0] && !config_.any_length) continue;
    const Verdict verdict = JudgeElsewhere(data, mode, ended);
    if (verdict == Verdict::kPacket) {
      ++stats_.locks;
      return {verdict, mode};
    }
    need_more = need_more || verdict == Verdict::kNeedMore;
  }
  if (need_more) return {Verdict::kNeedMore, {}};
  if (due_but_wrong) ++stats_.bad_checksum;
  return {};
}

/// A packet is due where the grid of the last ones says, up to a few packets on.
bool Ahrs400Decoder::IsDue(std::size_t packet_bytes) const {
  const std::uint64_t beyond = buffer_.position() - grid_position_;
  return beyond % packet_bytes == 0 && beyond / packet_bytes <= kGridReach;
}

Ahrs400Decoder::Verdict Ahrs400Decoder::JudgeElsewhere(std::span<const std::uint8_t> data,
                                                       Ahrs400Mode mode, bool ended) const {
  const std::size_t n = PacketBytes(mode);
  std::size_t needed = 2;
  for (std::size_t frames = 0; frames < needed; ++frames) {
    const auto rest = data.subspan(std::min(frames * n, data.size()));
    if (!rest.empty() && rest.front() != kAhrs400Header) return Verdict::kNothing;
    if (rest.size() < n) {
      if (!ended) return Verdict::kNeedMore;
      return frames > 0 ? Verdict::kPacket : Verdict::kNothing;
    }
    if (!Ahrs400FrameFits(rest.first(n))) return Verdict::kNothing;
    if (!IsPlausibleAhrs400(rest.first(n), mode)) needed = 3;
  }
  return Verdict::kPacket;
}

bool Ahrs400Decoder::IsFrozen(std::span<const std::uint8_t> frame, Ahrs400Mode mode) {
  const bool same = has_last_ && last_mode_ == mode &&
                    std::equal(frame.begin(), frame.end(), last_frame_.begin());
  std::copy(frame.begin(), frame.end(), last_frame_.begin());
  last_mode_ = mode;
  has_last_ = true;
  return same;
}

void Ahrs400Decoder::TakePacket(Ahrs400Mode mode, Ahrs400Sink& sink) {
  const auto frame = buffer_.data().first(PacketBytes(mode));
  const core::MonoTime arrival = buffer_.FrontStamp();
  ++stats_.packets[static_cast<std::size_t>(mode)];
  const bool counter_moves =
      !has_last_ || last_mode_ != mode ||
      Ahrs400Counter(frame) !=
          Ahrs400Counter(std::span(last_frame_).first(PacketBytes(last_mode_)));
  if (IsFrozen(frame, mode)) {
    ++stats_.frozen;
    sink.OnFrozen(arrival, mode);
  } else {
    // A counter that stands still while the data move cannot date anything.
    const core::MonoTime sampled = counter_moves
                                       ? clock_.Update(Ahrs400Counter(frame), arrival, bytes_lost_)
                                       : arrival - config_.clock.latency;
    if (mode == Ahrs400Mode::kVoltage) {
      Ahrs400Voltages voltages = ScaleAhrs400Voltages(frame);
      voltages.arrival = arrival;
      voltages.sampled = sampled;
      sink.OnVoltages(voltages);
    } else {
      core::AhrsSample sample = ScaleAhrs400(frame, mode, config_.scaling);
      sample.arrival = arrival;
      sample.sampled = sampled;
      sink.OnSample(sample, mode);
    }
  }
  buffer_.Consume(frame.size());
  locked_ = true;
  after_version_ = false;
  bytes_lost_ = false;
  grid_mode_ = mode;
  grid_position_ = buffer_.position();
}

}  // namespace kawara::drivers
