#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"

namespace kawara::sim {

/// A CSV file of numbers with a header line, plain or gzip, as rows of doubles in the columns asked
/// for.
struct NumberTable {
  std::string file;  ///< as opened, for messages
  std::vector<std::vector<double>> rows;

  /// "FILE:LINE: column NAME: what" as an error of this table's row.
  core::Error RowError(std::size_t row, std::string_view column, const std::string& what) const;
};

/// Opens `path`, or `path`.gz if that is what is there. Every name in `columns` must be in the
/// header; others are ignored. Errors: kNotFound; kIo (also damaged gzip); kFormat with file, line
/// and column.
core::Expected<NumberTable> ReadNumberTable(const std::filesystem::path& path,
                                            const std::vector<std::string>& columns);

}  // namespace kawara::sim
