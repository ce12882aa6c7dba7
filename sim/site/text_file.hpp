#pragma once
#include <string>

#include "core/expected.hpp"
#include "core/geodesy.hpp"

/// Small helpers of the writers of truth.
namespace kawara::sim {

/// Beside its place, then renamed: a reader finds the old file or the whole new one.
core::Expected<void> WriteTextFile(const std::string& path, const std::string& text);

/// With a fixed number of decimals, the point as decimal mark whatever the locale, never "-0".
std::string Fixed(double value, int decimals);
/// In quotes, escaped as JSON wants.
std::string JsonText(const std::string& text);
/// A CSV field, in quotes where it must be.
std::string CsvText(const std::string& text);
/// "[lon, lat, h]"
std::string JsonPosition(const core::Geodetic& g);

}  // namespace kawara::sim
