#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "drivers/ntrip_request.hpp"
#include "drivers/ntrip_source.hpp"

namespace kawara::drivers {

enum class NtripState : std::uint8_t {
  kHead,         ///< status line or headers are still coming
  kStreaming,    ///< corrections flow
  kSourcetable,  ///< the caster sends its list of mountpoints instead
  kDone,  ///< the answer is over: end of chunks, of the table, or after a refusal; see failure()
};

enum class NtripFailure : std::uint8_t {
  kNone,
  kWrongPassword,    ///< 401, 403, ERROR - Bad Password
  kWrongMountpoint,  ///< 404, or the source table came instead of data
  kMountpointInUse,  ///< 409
  kRedirected,       ///< 3xx: we do not follow
  kServerError,      ///< 5xx and other codes
  kNotNtrip,         ///< some other server
  kEncoding,         ///< an encoding that nobody asked for (gzip)
  kBrokenChunk,      ///< transfer encoding damaged: bytes were lost or it is no chunked stream
  kEnded,            ///< the caster said that the stream is over
};

/// What an NTRIP caster answers, as a pure decoder: versions 1 ("ICY 200 OK", with or without a
/// blank line or headers after it) and 2 (HTTP/1.1, chunked or not, chunk borders anywhere), source
/// tables, refusals.
///   while (auto payload = decoder.Next(bytes)) Use(*payload);
/// Any split of the bytes gives the same payload. Memory is bounded: lines up to 1 KB, tables up to
/// 4096 entries. Not for the real-time path (the table allocates). One thread.
class NtripDecoder {
 public:
  /// `wants_table`: the request had no mountpoint, so a source table is what was asked for.
  explicit NtripDecoder(bool wants_table = false) : wants_table_(wants_table) {}

  /// Takes bytes off the front of `bytes` up to and including the next run of payload and returns
  /// that, a view into `bytes` or into this object, valid until the next call. No value: all bytes
  /// are used up.
  std::optional<std::span<const std::uint8_t>> Next(std::span<const std::uint8_t>& bytes);
  /// The connection was closed by the caster.
  void OnClosed();

  NtripState state() const { return state_; }
  NtripFailure failure() const { return failure_; }
  bool chunked() const { return chunked_; }
  int version() const { return version_; }  ///< of the answer: 1 or 2; 0 unknown yet
  /// First line of the answer.
  const std::string& status_line() const { return status_line_; }
  const std::vector<NtripSource>& sources() const { return sources_; }
  std::uint64_t payload_bytes() const { return payload_bytes_; }
  std::uint64_t chunks() const { return chunks_; }

  /// One line for people, with the cure: what `request` met. Only after a failure.
  core::Error Explain(const NtripRequest& request) const;

 private:
  enum class Phase : std::uint8_t {
    kStatus,
    kAfterIcy,
    kHeaders,
    kBody,
    kChunkSize,
    kChunkData,
    kChunkEnd,
    kTrailer,
    kOver
  };
  std::optional<std::span<const std::uint8_t>> Body(std::span<const std::uint8_t> body);
  bool TakeLine(std::span<const std::uint8_t>& bytes);
  void OnStatusLine();
  void OnHeader();
  void OnHeadersDone();
  void OnTableLine();
  void OnChunkSize();
  bool AfterIcy(std::span<const std::uint8_t>& bytes);
  void Stream();
  void Fail(NtripFailure failure);

  bool wants_table_;
  Phase phase_ = Phase::kStatus;
  NtripState state_ = NtripState::kHead;
  NtripFailure failure_ = NtripFailure::kNone;
  int version_ = 0;
  int http_code_ = 0;
  bool chunked_ = false;
  bool digest_ = false;
  bool is_table_ = false;
  bool is_web_page_ = false;
  bool line_too_long_ = false;
  std::uint64_t body_left_ = UINT64_MAX;  ///< from Content-Length
  std::uint64_t chunk_left_ = 0;
  std::string line_;
  std::string released_;  ///< bytes held back that turned out to be payload
  std::string status_line_;
  std::string encoding_;
  std::string location_;
  std::string table_line_;
  std::vector<NtripSource> sources_;
  std::uint64_t payload_bytes_ = 0;
  std::uint64_t chunks_ = 0;
};

}  // namespace kawara::drivers
