#pragma once
#include <set>
#include <string>

#include "gis/kiwi/kiwi_plus_writer.hpp"
#include "gis/ogr_dataset.hpp"

namespace kawara::gis {

/// Bounds of an element's begin and end: existence was seen from begin_max to end_min, absence
/// until begin_min and from end_max. Not set: not known.
struct ExistenceBounds {
  core::UtcTime begin_min, begin_max;
};

/// Transaction time: when and by whom this store was told. Not set: not noted.
struct Told {
  core::UtcTime at;
  std::string who;
};

/// The profile's tables kp_* of a GeoPackage or a PostGIS database whose schema is there
/// (KiwiSchema). Rows join the caller's transaction. Errors: of the dataset. Inside gis/ only.
class KiwiTables : public KiwiPlusWriter {
 public:
  /// `told`: of everything written or closed through this object.
  KiwiTables(OgrDataset& dataset, Told told) : dataset_(dataset), told_(std::move(told)) {}

  using KiwiPlusWriter::Write;
  /// Nothing happens to a feature space that is there already.
  core::Expected<void> Write(const FeatureSpace& space) override;
  core::Expected<void> Write(const VectorElement& vector) override;
  core::Expected<void> Write(const ConnectorElement& connector) override;
  core::Expected<void> Write(const Attribute& attribute) override;
  /// An end that is set already stays.
  core::Expected<void> Close(ElementKind kind, const std::string& id, core::UtcTime end) override;

  core::Expected<void> WriteBounds(const std::string& element_id, const ExistenceBounds& bounds);
  core::Expected<void> CloseBounds(const std::string& element_id, core::UtcTime end_min,
                                   core::UtcTime end_max);
  /// A fact about the whole; the first one said stays.
  core::Expected<void> WriteMeta(const std::string& key, const std::string& value);

  /// Extents and change stamps of the layers touched: once before the commit.
  core::Expected<void> Finish();

 private:
  core::Expected<void> WriteTold(const std::string& element_id);
  core::Expected<OGRLayer*> LayerOf(const char* table);

  OgrDataset& dataset_;
  Told told_;
  std::set<const char*> touched_;
};

}  // namespace kawara::gis
