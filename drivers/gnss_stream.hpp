#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.hpp"
#include "drivers/gnss_message.hpp"
#include "drivers/rtcm2_decoder.hpp"

namespace kawara::drivers {

/// Takes what GnssStreamDecoder finds.
class GnssStreamSink {
 public:
  virtual ~GnssStreamSink() = default;
  virtual void OnMessage(const GnssMessage& message) = 0;
};

/// Finds all messages in the byte stream of a GNSS receiver, whatever mixture it sends: NMEA,
/// $PASHR text, Ashtech binary records, u-blox frames, RTCM 3 and RTCM 2.
///
/// Feed() takes any split of the bytes and gives the same messages for each; a message comes out
/// with its last checksum byte. Header bytes occur inside payloads: a message is believed by its
/// checksum alone, and after a disappointment the search goes on ONE byte later, over bytes held in
/// a fixed buffer. A binary header that was a lie would hold back what follows until its claimed
/// length is full; so a whole text sentence with the right checksum inside it proves it wrong at
/// once.
///
/// Every byte ends up in exactly one of three: part of a good message (with its CR LF), of a bad
/// one (looked like a message up to its checksum), or skipped. A binary frame with a wrong checksum
/// is a bad message if it began where one is expected (right after another message or at the start
/// of the stream); anywhere else its header was a byte by chance, and it is skipped. RTCM 3 frames
/// with reserved bits set are taken only there, too, until the first ordinary frame has come.
///
/// Never throws, never allocates. One thread.
class GnssStreamDecoder {
 public:
  struct Stats {
    std::uint64_t good = 0;          ///< messages with the right checksum
    std::uint64_t bad_checksum = 0;  ///< messages with a wrong one
    std::uint64_t invalid = 0;       ///< of the good ones: contents their type cannot have
    std::uint64_t good_bytes = 0;
    std::uint64_t bad_bytes = 0;
    std::uint64_t skipped_bytes = 0;
    std::uint64_t rtcm2_parity_errors = 0;
  };

  /// `arrival` is that of bytes[0].
  void Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes, GnssStreamSink& sink);
  /// The stream has ended or was interrupted: what is held is decided as far as it goes, the rest
  /// is skipped.
  void Finish(GnssStreamSink& sink);

  /// good_bytes + bad_bytes + skipped_bytes + pending_bytes() = bytes fed.
  const Stats& stats() const { return stats_; }
  std::size_t pending_bytes() const { return end_ - begin_; }

 private:
  /// Two of the longest message: a block always fits behind an unfinished one.
  static constexpr std::size_t kCapacity = 8192;
  static_assert(kCapacity >= 2 * kUbxMaxBytes);
  /// From which stream offset on bytes came at which time.
  struct Mark {
    std::uint64_t offset = 0;
    core::MonoTime arrival;
  };
  enum class Closing : std::uint8_t { kNone, kCrLf, kLf };

  void Process(bool final, GnssStreamSink& sink);
  bool TryText(bool final, GnssStreamSink& sink);
  bool TryRtcm3(bool final, GnssStreamSink& sink);
  bool TryUbx(bool final, GnssStreamSink& sink);
  void TakeClosing();
  void Skip(std::size_t bytes, GnssStreamSink& sink);
  void Accept(std::size_t bytes, GnssMessage& message, GnssStreamSink& sink);
  void Deliver(GnssMessage& message, GnssStreamSink& sink);
  void DeliverRtcm2(const Rtcm2Message& rtcm2, GnssStreamSink& sink);
  void RejectFrame(std::size_t bytes, GnssStreamSink& sink);
  void AddMark(core::MonoTime arrival);
  core::MonoTime ArrivalOf(std::uint64_t offset);

  std::span<const std::uint8_t> Held() const { return {buffer_.data() + begin_, end_ - begin_}; }
  void Advance(std::size_t bytes) {
    begin_ += bytes;
    offset_ += bytes;
  }
  bool AtBoundary() const { return offset_ == boundary_; }

  Stats stats_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t offset_ = 0;     ///< in the stream, of buffer_[begin_]
  std::uint64_t boundary_ = 0;   ///< where a message is expected to begin
  std::uint64_t bad_until_ = 0;  ///< end of the newest bad frame
  Closing closing_ = Closing::kNone;
  bool closing_is_good_ = true;
  bool rtcm3_seen_ = false;
  Rtcm2Decoder rtcm2_;
  std::uint64_t marks_begin_ = 0;
  std::uint64_t marks_end_ = 0;
  std::array<Mark, kCapacity> marks_{};  ///< ring: no more marks than bytes held
  std::array<std::uint8_t, kCapacity> buffer_{};
};

}  // namespace kawara::drivers
