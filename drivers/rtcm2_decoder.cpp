#include "drivers/rtcm2_decoder.hpp"

#include <algorithm>

#include "drivers/rtcm2_word.hpp"

namespace kawara::drivers {
namespace {

constexpr unsigned kHourUnits = 6000;  ///< Z-count: 0.6 s
constexpr core::Duration kZUnit = std::chrono::milliseconds(600);
/// Step in Z-count between messages that follow each other. GLONASS observations are dated in UTC,
/// so they stand the leap seconds behind the GPS ones of the same epoch (seen: 15 s in 2009);
/// position messages may be older too.
constexpr unsigned kBackUnits = 50;  // 30 s
constexpr std::uint64_t kConfirmWithinBytes = 65536;
constexpr unsigned kForwardUnits = 200;  // 120 s

/// Data bytes to their six bits in order of time, most significant first; 0x80 for bytes to be
/// skipped.
constexpr std::uint8_t kNotData = 0x80;
constexpr std::array<std::uint8_t, 256> MakeSextets() {
  std::array<std::uint8_t, 256> table{};
  for (unsigned b = 0; b < 256; ++b) {
    unsigned reversed = 0;
    for (unsigned i = 0; i < kRtcm2BitsPerByte; ++i)
      reversed |= ((b >> i) & 1U) << (kRtcm2BitsPerByte - 1 - i);
    table[b] = (b & 0xC0U) == 0x40U ? static_cast<std::uint8_t>(reversed) : kNotData;
  }
  return table;
}
constexpr auto kSextets = MakeSextets();

/// For the 13 bits in which a preamble may lie: bit k is set where it (or its inverse) begins k
/// bits up.
constexpr std::array<std::uint8_t, 8192> MakePreambleShifts() {
  std::array<std::uint8_t, 8192> table{};
  for (unsigned window = 0; window < table.size(); ++window) {
    unsigned shifts = 0;
    for (unsigned k = 0; k < kRtcm2BitsPerByte; ++k) {
      const unsigned byte = (window >> k) & 0xFFU;
      if (byte == kRtcm2Preamble || byte == (kRtcm2Preamble ^ 0xFFU)) shifts |= 1U << k;
    }
    table[window] = static_cast<std::uint8_t>(shifts);
  }
  return table;
}
constexpr auto kPreambleShifts = MakePreambleShifts();
unsigned PreambleShifts(std::uint64_t bits) { return kPreambleShifts[(bits >> 22) & 0x1FFF]; }

}  // namespace

const Rtcm2Message* Rtcm2Decoder::Next(std::span<const std::uint8_t>& bytes) noexcept {
  if (pending_) return EmitLast();
  const std::uint8_t* p = bytes.data();
  const std::uint8_t* const end = p + bytes.size();
  const Rtcm2Message* message = nullptr;
  while (p != end && message == nullptr) {
    if (!locked_ && !any_track_) {
      p = Scan(p, end);
      continue;
    }
    const std::uint8_t sextet = kSextets[*p++];
    ++stats_.bytes;
    if (sextet == kNotData) continue;
    positions_[data_bytes_++ % positions_.size()] = stats_.bytes - 1;
    bits_ = (bits_ << kRtcm2BitsPerByte) | sextet;
    message = OnDataByte();
  }
  bytes = bytes.last(static_cast<std::size_t>(end - p));
  return message;
}

std::optional<Rtcm2Message> Rtcm2Decoder::Feed(std::uint8_t byte) noexcept {
  std::optional<Rtcm2Message> result;
  // A message is at least ten bytes long: after a pending one this byte can not complete another.
  if (pending_) result = *EmitLast();
  std::span<const std::uint8_t> one(&byte, 1);
  if (const Rtcm2Message* message = Next(one)) result = *message;
  return result;
}

void Rtcm2Decoder::Reset() noexcept {
  for (Track& track : tracks_) track.active = false;
  locked_ = any_track_ = has_last_ = last_is_out_ = pending_ = false;
  bits_ = 0;
  data_bytes_ = 0;
}

/// Noise at full speed: nothing but the search for a preamble, without branches that depend on the
/// bytes.
const std::uint8_t* Rtcm2Decoder::Scan(const std::uint8_t* p, const std::uint8_t* end) noexcept {
  std::uint64_t bits = bits_;
  std::uint64_t count = data_bytes_;
  std::uint64_t position = stats_.bytes;
  while (p != end) {
    const std::uint8_t sextet = kSextets[*p++];
    const bool is_data = sextet != kNotData;
    positions_[count % positions_.size()] =
        position++;  // the next byte overwrites it if this one is no data
    count += is_data ? 1 : 0;
    bits = is_data ? (bits << kRtcm2BitsPerByte) | sextet : bits;
    if ((PreambleShifts(bits) & (is_data ? 0xFFU : 0U)) == 0) continue;
    bits_ = bits;
    data_bytes_ = count;
    StartTracks();
    if (any_track_) break;
  }
  bits_ = bits;
  data_bytes_ = count;
  stats_.bytes = position;
  return p;
}

/// Opens a hypothesis at every word ending in the newest byte that looks like header word 1. The
/// two bits before the word are taken from the stream as the standard says, whatever they were:
/// right after foreign text a first message is therefore read in one case of four only.
void Rtcm2Decoder::StartTracks() noexcept {
  const unsigned shifts = PreambleShifts(bits_);
  if (shifts == 0) return;
  for (unsigned k = kRtcm2BitsPerByte; k-- > 0;) {
    const unsigned bytes_touched = kRtcm2BytesPerWord + (k > 0 ? 1 : 0);
    if (((shifts >> k) & 1U) == 0 || data_bytes_ < bytes_touched) continue;
    std::uint32_t data = 0;
    const auto word = static_cast<std::uint32_t>(bits_ >> k);
    if (!ReadRtcm2Word(word, data) || (data >> 16) != kRtcm2Preamble) continue;
    const auto slot =
        std::find_if(tracks_.begin(), tracks_.end(), [](const Track& t) { return !t.active; });
    if (slot == tracks_.end()) return;
    slot->active = any_track_ = true;
    slot->shift = k;
    slot->wait = kRtcm2BytesPerWord;
    slot->words = 1;
    slot->begin = positions_[(data_bytes_ - bytes_touched) % positions_.size()];
    slot->message.type = static_cast<std::uint8_t>((data >> 10) & 0x3FU);
    slot->message.bits_before = static_cast<std::uint8_t>(word >> kRtcm2WordBits);
    slot->message.station = static_cast<std::uint16_t>(data & 0x3FFU);
  }
}

const Rtcm2Message* Rtcm2Decoder::OnDataByte() noexcept {
  if (locked_) {
    Track& track = tracks_[0];
    return --track.wait == 0 ? OnLockedWord(track) : nullptr;
  }
  any_track_ = false;
  for (Track& track : tracks_) {
    if (!track.active) continue;
    if (--track.wait == 0) {
      const Word word = TakeWord(track);
      if (word == Word::kHeader && FitsLast(track.message)) return LockOn(track);
      const bool complete =
          word == Word::kComplete || (word == Word::kHeader && track.message.data_words == 0);
      if (complete) Complete(track);
      if (complete || word == Word::kBad) track.active = false;
    }
    any_track_ = any_track_ || track.active;
  }
  StartTracks();
  return nullptr;
}

const Rtcm2Message* Rtcm2Decoder::OnLockedWord(Track& track) noexcept {
  const Word word = TakeWord(track);
  if (word == Word::kBad) {
    locked_ = track.active = any_track_ = false;
    StartTracks();  // a header may end with this very byte
    return nullptr;
  }
  const bool complete =
      word == Word::kComplete || (word == Word::kHeader && track.message.data_words == 0);
  if (word == Word::kHeader && !FitsLast(track.message)) {
    // Another station, or its clock jumped: it has to prove itself like any other.
    locked_ = false;
    any_track_ = true;
    if (complete) {
      Complete(track);
      track.active = any_track_ = false;
    }
    return nullptr;
  }
  if (!complete) return nullptr;
  Complete(track);
  return EmitLast();
}

/// Takes the word that ends `shift` bits before the newest bit.
Rtcm2Decoder::Word Rtcm2Decoder::TakeWord(Track& track) noexcept {
  track.wait = kRtcm2BytesPerWord;
  const auto word = static_cast<std::uint32_t>(bits_ >> track.shift);
  std::uint32_t data = 0;
  const bool good = ReadRtcm2Word(word, data);
  Rtcm2Message& m = track.message;
  if (track.words == 0 && (data >> 16) != kRtcm2Preamble)
    return Word::kBad;  // something else follows the message
  if (!good) {
    if (locked_) ++stats_.parity_errors;
    return Word::kBad;
  }
  ++track.words;
  switch (track.words) {
    case 1: {
      const unsigned bytes_touched = kRtcm2BytesPerWord + (track.shift > 0 ? 1 : 0);
      track.begin = positions_[(data_bytes_ - bytes_touched) % positions_.size()];
      m.type = static_cast<std::uint8_t>((data >> 10) & 0x3FU);
      m.bits_before = static_cast<std::uint8_t>(word >> kRtcm2WordBits);
      m.station = static_cast<std::uint16_t>(data & 0x3FFU);
      return Word::kMore;
    }
    case 2: {
      const std::uint32_t z_count = data >> 11;
      if (z_count >= kHourUnits) return Word::kBad;
      m.time_of_hour = z_count * kZUnit;
      m.sequence = static_cast<std::uint8_t>((data >> 8) & 7U);
      m.data_words = static_cast<std::uint8_t>((data >> 3) & 0x1FU);
      m.health = static_cast<std::uint8_t>(data & 7U);
      m.data.fill(0);
      return Word::kHeader;
    }
    default:
      m.data[track.words - 3] = data;
      return track.words - 2 == m.data_words ? Word::kComplete : Word::kMore;
  }
}

/// Whether a header may be that of the message after last_. Unlocked, that has to come soon, and
/// not as the very same header again: repeated noise repeats its accidents too.
bool Rtcm2Decoder::FitsLast(const Rtcm2Message& m) const noexcept {
  if (!has_last_ || m.station != last_.station) return false;
  const auto units = [](const Rtcm2Message& message) {
    return static_cast<unsigned>(message.time_of_hour / kZUnit);
  };
  const unsigned step = (units(m) + kHourUnits + kBackUnits - units(last_)) % kHourUnits;
  if (step > kBackUnits + kForwardUnits) return false;
  if (locked_) return true;
  const bool same_again =
      step == kBackUnits && m.sequence == last_.sequence && m.type == last_.type;
  return stats_.bytes - last_.stream_end <= kConfirmWithinBytes && (last_is_out_ || !same_again);
}

/// `track` holds a header that fits the last message: follow it and it alone.
const Rtcm2Message* Rtcm2Decoder::LockOn(Track& track) noexcept {
  if (&track != &tracks_[0]) tracks_[0] = track;
  for (std::size_t i = 1; i < kTracks; ++i) tracks_[i].active = false;
  locked_ = any_track_ = true;
  ++stats_.locks;
  const Rtcm2Message* first = last_is_out_ ? nullptr : EmitLast();
  if (tracks_[0].message.data_words > 0) return first;
  Complete(tracks_[0]);
  if (first == nullptr) return EmitLast();
  pending_ = true;
  return first;
}

/// The message of `track` is whole and becomes the last one, to be handed out now or once it is
/// confirmed.
void Rtcm2Decoder::Complete(Track& track) noexcept {
  track.words = 0;
  if (has_last_ && !last_is_out_) {
    ++stats_.unconfirmed;
    // Of two that overlap one is false: the one with fewer words to prove itself.
    const bool overlap = track.begin + 1 < last_.stream_end;
    if (overlap && track.message.data_words < last_.data_words) return;
  }
  last_ = track.message;
  if (last_.type == 0) last_.type = 64;  // six bits
  last_.stream_end = stats_.bytes;
  last_.stream_bytes = static_cast<std::size_t>(last_.stream_end - std::max(track.begin, out_end_));
  has_last_ = true;
  last_is_out_ = false;
}

const Rtcm2Message* Rtcm2Decoder::EmitLast() noexcept {
  pending_ = false;
  last_is_out_ = true;
  out_end_ = last_.stream_end;
  out_ = last_;
  DecodeRtcm2Body(out_);
  ++stats_.messages;
  stats_.message_bytes += out_.stream_bytes;
  return &out_;
}

}  // namespace kawara::drivers
