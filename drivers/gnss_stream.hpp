#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.hpp"
#include "drivers/gnss_message.hpp"

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
/// is a bad message if it began where one is expected (right after a good message or at the start
/// of the stream); anywhere else it was a header byte by chance, and its bytes are skipped.
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

  GnssStreamDecoder();
  ~GnssStreamDecoder();
  GnssStreamDecoder(const GnssStreamDecoder&) = delete;
  GnssStreamDecoder& operator=(const GnssStreamDecoder&) = delete;

  /// `arrival` is that of bytes[0].
  void Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes, GnssStreamSink& sink);
  /// The stream has ended or was interrupted: what is held is decided as far as it goes, the rest
  /// is skipped.
  void Finish(GnssStreamSink& sink);

  /// good_bytes + bad_bytes + skipped_bytes + pending_bytes() = bytes fed.
  const Stats& stats() const { return stats_; }
  std::size_t pending_bytes() const { return end_ - begin_; }

 private:
  Stats stats_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

}  // namespace kawara::drivers
