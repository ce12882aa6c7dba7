#pragma once
#include <cstdint>

/// Wire format between the simulated camera (server, sim/) and drivers::SocketCamera (client), over
/// a UNIX stream socket on one machine. All fields little-endian, structs packed as declared (no
/// implicit padding). The client sends a CameraTriggerMessage for every exposure; the server
/// answers each frame with a CameraFrameHeader followed by `payload_bytes` bytes. Stamps are
/// CLOCK_MONOTONIC of the shared machine.
namespace kawara::drivers {

constexpr std::uint32_t kCameraTriggerMagic = 0x4752544bU;  ///< "KTRG"
constexpr std::uint32_t kCameraFrameMagic = 0x4d52464bU;    ///< "KFRM"
constexpr std::uint32_t kCameraMaxPayloadBytes = 64U << 20;

struct CameraTriggerMessage {
  std::uint32_t magic = kCameraTriggerMagic;
  std::uint32_t sequence = 0;
  std::int64_t mono_ns = 0;
};
static_assert(sizeof(CameraTriggerMessage) == 16);

struct CameraFrameHeader {
  std::uint32_t magic = kCameraFrameMagic;
  std::uint32_t sequence = 0;
  std::uint32_t trigger_sequence = 0;
  std::uint32_t format = 1;  ///< drivers::PixelFormat
  std::int64_t exposure_start_mono_ns = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t payload_bytes = 0;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(CameraFrameHeader) == 40);

}  // namespace kawara::drivers
