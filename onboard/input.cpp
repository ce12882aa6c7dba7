#include "onboard/input.hpp"

#include <array>
#include <utility>

namespace kawara::onboard {
namespace {

constexpr std::array<std::pair<InputKind, std::string_view>, 12> kChannels{{
    {InputKind::kGpsBytes, "RAW.GPS"},
    {InputKind::kAhrsBytes, "RAW.AHRS"},
    {InputKind::kCorrectionBytes, "RAW.CORRECTIONS"},
    {InputKind::kTick, "RAW.TICK"},
    {InputKind::kPort, "RAW.PORT"},
    {InputKind::kCommand, "RAW.COMMAND"},
    {InputKind::kPictureDone, "RAW.DONE"},
    {InputKind::kSystemClock, "RAW.UTC"},
    {InputKind::kNote, "RAW.NOTE"},
    {InputKind::kPulse, "RAW.PPS"},
    {InputKind::kShutter, "RAW.SHUTTER"},
    {InputKind::kFrame, "FRAME"},
}};

std::string_view TextOf(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class Number>
std::array<std::uint8_t, sizeof(Number)> LittleEndian(Number value) {
  std::array<std::uint8_t, sizeof(Number)> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
  return bytes;
}

template <class Number>
bool FromLittleEndian(std::span<const std::uint8_t> bytes, Number& value) {
  if (bytes.size() != sizeof(value)) return false;
  value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) value |= Number{bytes[i]} << (8 * i);
  return true;
}

bool ToSeverity(char c, core::Severity& severity) {
  if (c < '0' || c > '3') return false;
  severity = static_cast<core::Severity>(c - '0');
  return true;
}

}  // namespace

// Both notes are text, so that an exported log can be read: "<port><open><changed><severity><text>"
// with one digit each, and "<severity><name> <text>".
NoteBytes Pack(const PortNote& note) {
  NoteBytes bytes;
  bytes.Append(static_cast<int>(note.port)).Append(note.open ? "1" : "0");
  return bytes.Append(note.changed ? "1" : "0")
      .Append(static_cast<int>(note.severity))
      .Append(note.text);
}

NoteBytes Pack(const EventNote& note) {
  NoteBytes bytes;
  return bytes.Append(static_cast<int>(note.severity))
      .Append(note.name)
      .Append(" ")
      .Append(note.text);
}

std::array<std::uint8_t, 4> Pack(std::uint32_t pulse_sequence) {
  return LittleEndian(pulse_sequence);
}
std::array<std::uint8_t, 8> Pack(core::Duration length) {
  return LittleEndian(static_cast<std::uint64_t>(length.count()));
}

bool Unpack(std::span<const std::uint8_t> bytes, std::uint32_t& pulse_sequence) {
  return FromLittleEndian(bytes, pulse_sequence);
}

bool Unpack(std::span<const std::uint8_t> bytes, core::Duration& length) {
  std::uint64_t ns = 0;
  if (!FromLittleEndian(bytes, ns)) return false;
  length = core::Duration(static_cast<std::int64_t>(ns));
  return true;
}

bool Unpack(std::span<const std::uint8_t> bytes, PortNote& note) {
  const std::string_view text = TextOf(bytes);
  if (text.size() < 4 || text[0] < '0' || text[0] > '3') return false;
  note.port = static_cast<PortId>(text[0] - '0');
  note.open = text[1] == '1';
  note.changed = text[2] == '1';
  note.text = text.substr(4);
  return ToSeverity(text[3], note.severity);
}

bool Unpack(std::span<const std::uint8_t> bytes, EventNote& note) {
  const std::string_view text = TextOf(bytes);
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos || space < 2) return false;
  note.name = text.substr(1, space - 1);
  note.text = text.substr(space + 1);
  return ToSeverity(text[0], note.severity);
}

std::string_view ChannelOf(InputKind kind) {
  for (const auto& [k, name] : kChannels) {
    if (k == kind) return name;
  }
  return {};
}

bool KindOf(std::string_view channel, InputKind& kind) {
  for (const auto& [k, name] : kChannels) {
    if (name == channel) {
      kind = k;
      return true;
    }
  }
  return false;
}

}  // namespace kawara::onboard
