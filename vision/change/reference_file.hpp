#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "vision/change/reference_map.hpp"

namespace kawara::vision {

/// A reference as one file (docs/reference_format.md), little-endian:
///
///   "KWREF001", u32 CRC-32 of everything after it
///   u8 has_origin, 3 f64 latitude, longitude [deg], ellipsoidal height [m]
///   f64 voxel_m, f64 ground_cell_m
///   u32 n sources:  name, kind (u32 length and UTF-8 each), i64 UTC ns (0: not known), f64 sd_m
///   u64 n patches:  3 i32 voxel, 3 f32 mean [m], 3 f32 normal, f32 thickness_m, f32 sd_m, u32
///                   points, u16 source
///   u64 n ground:   2 i32 cell, f32 up_m, f32 sd_m
///   u32 n roads:    name, u32 n rings, each u32 n points of 2 f64 [m]; the first ring is the outer
///   u32 n axes:     name, u32 n points of 2 f64 [m]
///
/// The same map gives the same bytes.
std::vector<std::uint8_t> EncodeReference(const ReferenceMap& reference);
/// Errors: kFormat, with what is wrong.
core::Expected<ReferenceMap> DecodeReference(std::span<const std::uint8_t> bytes);

/// That a file begins as one.
bool IsReferenceFile(const std::filesystem::path& path);
/// Errors: kNotFound, kPermission, kFormat.
core::Expected<ReferenceMap> ReadReference(const std::filesystem::path& path);

}  // namespace kawara::vision
