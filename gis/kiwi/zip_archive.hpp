#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"

namespace kawara::gis {

/// A ZIP archive in memory, entries stored as they are (JPEGs do not get smaller, the rest is
/// small), dates at the format's epoch: the same entries give the same bytes. Limits of ZIP without
/// its 64-bit extension: 65535 entries, 4 GiB. Source: PKWARE APPNOTE 6.3.3, 4.3.7, 4.3.12, 4.3.16.
class ZipArchive {
 public:
  /// `name` with forward slashes, UTF-8. kFull: over the limits.
  core::Expected<void> Add(const std::string& name, std::string_view bytes);
  /// The whole file.
  std::string Finish() const;

 private:
  std::string entries_;
  std::string directory_;
  std::uint32_t count_ = 0;
};

}  // namespace kawara::gis
