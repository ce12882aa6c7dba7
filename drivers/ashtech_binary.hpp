#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/time.hpp"

/// Binary records that Ashtech receivers send between their text lines: "$PASHR,PBN," + a structure
/// with its own checksum + CR LF. The structure may contain CR, LF, '$' and everything else, so its
/// length is known beforehand or not at all. Source: Z-Family Technical Reference Manual, tables of
/// PBN and MBN; DG14 manual (MCA); verified on a recorded AC12.
namespace kawara::drivers {

/// PBN: position and velocity in ECEF, GPS time of week. NEVER the RTK solution: autonomous or
/// code-differential.
struct AshtechPbn {
  core::Duration time_of_week{};
  std::array<char, 4> site{};
  Eigen::Vector3d ecef_m = Eigen::Vector3d::Zero();
  double clock_offset_m = 0.0;
  Eigen::Vector3d velocity_ecef_mps = Eigen::Vector3d::Zero();
  double clock_drift_mps = 0.0;
  double pdop = 0.0;
  bool plausible = false;  ///< time within a week, position near the Earth, finite velocity
};

enum class AshtechBinaryMatch : std::uint8_t {
  kNoMatch,  ///< not a record known here (text, perhaps)
  kNeedMore,
  kRecord,  ///< head[0, length) is a record with the right checksum; CR LF may follow
  kBadChecksum,
};
struct AshtechBinaryProbeResult {
  AshtechBinaryMatch match = AshtechBinaryMatch::kNoMatch;
  std::size_t length = 0;
  std::array<char, 3> type{};                 ///< "PBN", "MCA", ...
  std::span<const std::uint8_t> structure{};  ///< of kRecord, checksum included
};
/// Looks whether a record begins at head[0]. Its types: PBN, and MCA and MPC (raw measurements) to
/// be skipped whole. Text of the same type (the ASCII form) is told apart by what follows. Pure,
/// real-time safe.
AshtechBinaryProbeResult AshtechBinaryProbe(std::span<const std::uint8_t> head) noexcept;

/// Of a structure that AshtechBinaryProbe called kRecord with type PBN.
AshtechPbn DecodePbn(std::span<const std::uint8_t> structure) noexcept;

}  // namespace kawara::drivers
