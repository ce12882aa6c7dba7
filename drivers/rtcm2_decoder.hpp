#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/rtcm2.hpp"

namespace kawara::drivers {

/// Finds RTCM 2 in a byte stream of the 6-of-8 form: bytes 01xxxxxx carry six bits, least
/// significant first; every other byte (CR, LF, other protocols) is skipped. Words may begin at any
/// bit.
///
/// Preamble and parity alone are weak evidence (about one false message in 30 MB of noise), so
/// messages come out only once the decoder is LOCKED: after a whole message, within 64 KB, the
/// header of another one with the same station and a plausible step in time. The first then counts
/// too, late. From then on every message comes out with its last byte. Wrong parity loses that
/// message and the lock; the lock comes back with the next header that fits the last message.
///
/// Any split of the bytes gives the same messages. No allocation, no exceptions. One thread.
/// Source: link layer IS-GPS-200 (30-bit words, parity, inversion by the last bit of the word
/// before), RTCM 10402.3.
class Rtcm2Decoder {
 public:
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t messages = 0;
    std::uint64_t message_bytes = 0;  ///< sum of stream_bytes
    std::uint64_t parity_errors = 0;  ///< words with wrong parity while locked
    std::uint64_t locks = 0;
    std::uint64_t unconfirmed = 0;  ///< lone messages given up because nothing that fits followed
  };

  /// One byte in, at most one message out.
  std::optional<Rtcm2Message> Feed(std::uint8_t byte) noexcept;
  /// The fast way for blocks: takes bytes off the front of `bytes` until there is a message, null
  /// when all are used up. The message is valid until the next call.   while (const Rtcm2Message* m
  /// = decoder.Next(bytes)) Use(*m);
  const Rtcm2Message* Next(std::span<const std::uint8_t>& bytes) noexcept;

  bool locked() const { return locked_; }
  /// After a gap in the stream or another port: forgets lock and message begun. Statistics stay.
  void Reset() noexcept;
  const Stats& stats() const { return stats_; }

 private:
  /// A message being collected: one hypothesis of where a header began.
  struct Track {
    bool active = false;
    unsigned shift = 0;       ///< bits of the newest data byte that already belong to the next word
    unsigned wait = 0;        ///< data bytes until the next word is complete
    unsigned words = 0;       ///< words taken, header included; 0 = a header is expected next
    std::uint64_t begin = 0;  ///< stream position of the first byte
    Rtcm2Message message;
  };
  enum class Word : std::uint8_t { kMore, kHeader, kComplete, kBad };
  static constexpr std::size_t kTracks = 8;

  const std::uint8_t* Scan(const std::uint8_t* p, const std::uint8_t* end) noexcept;
  const Rtcm2Message* OnDataByte() noexcept;
  const Rtcm2Message* OnLockedWord(Track& track) noexcept;
  Word TakeWord(Track& track) noexcept;
  void StartTracks() noexcept;
  const Rtcm2Message* LockOn(Track& track) noexcept;
  void Complete(Track& track) noexcept;
  const Rtcm2Message* EmitLast() noexcept;
  bool FitsLast(const Rtcm2Message& message) const noexcept;

  bool locked_ = false;
  bool any_track_ = false;
  bool has_last_ = false;     ///< last_ is a whole message ...
  bool last_is_out_ = false;  ///< ... and was handed out
  bool pending_ = false;      ///< last_ is to be handed out at the next call
  std::uint64_t bits_ = 0;    ///< shift register, newest bit lowest
  std::uint64_t data_bytes_ = 0;
  std::uint64_t out_end_ = 0;  ///< stream_end of the last message handed out
  std::array<std::uint64_t, 8>
      positions_{};  ///< stream positions of the newest data bytes, by count modulo 8
  std::array<Track, kTracks> tracks_{};  ///< [0] is the one when locked
  Rtcm2Message last_;
  Rtcm2Message out_;
  Stats stats_;
};

}  // namespace kawara::drivers
