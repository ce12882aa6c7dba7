#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "drivers/pps.hpp"
#include "drivers/pps_socket.hpp"

namespace kawara::drivers {

/// Reads an edge as it came over the socket at `now`. kFormat: wrong magic, or a stamp that is not
/// of this machine's clock (not after its zero, or over kPpsFuture ahead). Pure; any thread.
core::Expected<PpsEdge> ParsePpsEdge(std::span<const std::uint8_t, sizeof(PpsEdgeMessage)> bytes,
                                     core::MonoTime now);
/// A stamp taken before it was sent cannot lie ahead; this much is forgiven.
constexpr core::Duration kPpsFuture = core::Milliseconds(1);

/// Puts edges together from the bytes of the socket, in whatever pieces they come. Holds less than
/// one. After an error the stream has no boundaries any more: reconnect and Reset(). One thread.
class PpsEdgeAssembler {
 public:
  /// Takes bytes off the front of `bytes` until an edge is complete or none is left (empty).
  core::Expected<std::optional<PpsEdge>> Feed(core::MonoTime now,
                                              std::span<const std::uint8_t>& bytes);
  void Reset() { size_ = 0; }

 private:
  std::array<std::uint8_t, sizeof(PpsEdgeMessage)> record_{};
  std::size_t size_ = 0;
};

/// Pulses from a UNIX stream socket (see pps_socket.hpp). Connects on demand in Next() and again
/// after every loss. Edges that waited in the socket for over kStale are passed over and counted:
/// what reads them late was not there. One thread.
class SocketPps final : public PpsSource {
 public:
  struct Stats {
    std::uint64_t connects = 0;
    std::uint64_t disconnects = 0;
    std::uint64_t edges = 0;
    std::uint64_t stale = 0;
    std::uint64_t format_errors = 0;
  };
  static constexpr core::Duration kStale = core::Milliseconds(900);

  explicit SocketPps(std::string path) : path_(std::move(path)) {}
  ~SocketPps() override;
  SocketPps(const SocketPps&) = delete;
  SocketPps& operator=(const SocketPps&) = delete;

  core::Expected<std::optional<PpsEdge>> Next(core::Duration timeout) override;
  const Stats& stats() const { return stats_; }

 private:
  core::Expected<void> Connect();
  tl::unexpected<core::Error> Lose(core::Error why);
  /// The next edge among the bytes that are here.
  core::Expected<std::optional<PpsEdge>> TakeBuffered();

  std::string path_;
  int fd_ = -1;
  PpsEdgeAssembler assembler_;
  std::array<std::uint8_t, 256> buffer_{};
  std::span<const std::uint8_t> rest_;  ///< of buffer_, not looked at yet
  Stats stats_;
};

}  // namespace kawara::drivers
