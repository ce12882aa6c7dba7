#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "gis/kiwi/kiwi_plus_writer.hpp"

namespace kawara::gis {

/// The exchange twin of the tables: feature_space.csv, vector.csv, connector.csv, attribute.csv in
/// one folder (RFC 4180, UTF-8, columns of kp_*, geometry as WKT), for whoever has no SQLite.
/// Everything is kept until Finish(), which writes each file whole. Errors: kInvalidArgument from
/// Close() of an element that is not there; of the files from Finish().
class KiwiCsv : public KiwiPlusWriter {
 public:
  explicit KiwiCsv(std::filesystem::path folder) : folder_(std::move(folder)) {}

  using KiwiPlusWriter::Write;
  core::Expected<void> Write(const FeatureSpace& space) override;
  core::Expected<void> Write(const VectorElement& vector) override;
  core::Expected<void> Write(const ConnectorElement& connector) override;
  core::Expected<void> Write(const Attribute& attribute) override;
  core::Expected<void> Close(ElementKind kind, const std::string& id, core::UtcTime end) override;

  /// The folder must exist.
  core::Expected<void> Finish() const;

 private:
  /// A line up to t_end, t_end, and the rest.
  struct Row {
    std::string head, end, tail;
  };
  struct Table {
    std::vector<Row> rows;
    std::map<std::string, std::size_t> by_id;
  };

  std::filesystem::path folder_;
  Table vectors_, connectors_;
  std::string spaces_, attributes_;
};

/// Feeds a writer with all that the kp_* tables of a store hold, in the order of the rows: feature
/// spaces, vectors, connectors (each closed after it if it has ended), attributes. Errors: the
/// store's, or the writer's first.
core::Expected<void> ReplayKiwiPlus(const std::string& target, KiwiPlusWriter& writer);

}  // namespace kawara::gis
