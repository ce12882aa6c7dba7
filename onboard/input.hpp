#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/events.hpp"
#include "core/fixed_text.hpp"
#include "core/time.hpp"

/// Everything that can reach the robot's core, in one numbered sequence. Live, the executive makes
/// the inputs and the recorder writes them down as consumed; in replay they come from the log. The
/// core cannot tell the difference.
namespace kawara::onboard {

enum class InputKind : std::uint8_t {
  kGpsBytes,         ///< bytes of the GPS receiver's port
  kAhrsBytes,        ///< bytes of the AHRS port
  kCorrectionBytes,  ///< RTCM from whatever source is configured
  kTick,             ///< time went on; no bytes
  kPort,             ///< a PortNote
  kCommand,          ///< "verb argument" of a command meant for this robot
  kPictureDone,      ///< one picture order is finished; no bytes
  kSystemClock,      ///< int64 little-endian: UTC ns of the computer's clock at `mono`
  kNote,             ///< an EventNote: something another thread has to tell
  kPulse,            ///< an edge of the receiver's PPS at `mono`; its uint32 count, little-endian
  kShutter,          ///< frames from now on are exposed so long: a Duration
  kFrame,            ///< a frame is here; the frame itself travels beside the input
};

enum class PortId : std::uint8_t { kGps = 0, kAhrs = 1, kCamera = 2, kPps = 3 };
constexpr std::size_t kPorts = 4;

struct Input {
  InputKind kind = InputKind::kTick;
  std::int64_t sequence = 0;  ///< 1, 2, 3, ... over all kinds
  core::MonoTime mono;        ///< of the first byte, or of the event
  std::span<const std::uint8_t> bytes;
};

/// What the core needs to know of a frame. `slot` is the executive's handle of the pixels.
struct FrameInput {
  std::int64_t sequence = 0;  ///< input sequence
  std::uint32_t slot = 0;
  std::uint32_t frame_sequence = 0;
  std::uint32_t trigger_sequence = 0;  ///< 0: the camera does not know
  core::MonoTime exposure_start;
  core::MonoTime arrival;
};

/// Payload of kPort: what happened to a port, and the line that tells it.
struct PortNote {
  PortId port = PortId::kGps;
  bool open = false;     ///< is now
  bool changed = false;  ///< was opened or lost just now
  core::Severity severity = core::Severity::kInfo;
  std::string_view text;  ///< empty: nothing to tell
};
/// Payload of kNote.
struct EventNote {
  core::Severity severity = core::Severity::kInfo;
  std::string_view name;
  std::string_view text;
};
using NoteBytes = core::FixedText<320>;
NoteBytes Pack(const PortNote& note);
NoteBytes Pack(const EventNote& note);
/// Payload of kPulse.
std::array<std::uint8_t, 4> Pack(std::uint32_t pulse_sequence);
/// Payload of kShutter: ns, little-endian.
std::array<std::uint8_t, 8> Pack(core::Duration length);
/// False: not what Pack made. Views point into `bytes`.
bool Unpack(std::span<const std::uint8_t> bytes, PortNote& note);
bool Unpack(std::span<const std::uint8_t> bytes, EventNote& note);
bool Unpack(std::span<const std::uint8_t> bytes, std::uint32_t& pulse_sequence);
bool Unpack(std::span<const std::uint8_t> bytes, core::Duration& length);
inline std::span<const std::uint8_t> BytesOf(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// LCM channel of an input in the log ("RAW.GPS", ...; frames: "FRAME").
std::string_view ChannelOf(InputKind kind);
/// Inverse of ChannelOf; false if it is not the channel of an input.
bool KindOf(std::string_view channel, InputKind& kind);

}  // namespace kawara::onboard
