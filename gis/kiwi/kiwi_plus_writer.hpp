#pragma once
#include <string>

#include "core/expected.hpp"
#include "gis/kiwi/elements.hpp"

namespace kawara::gis {

enum class ElementKind { kVector, kConnector };

/// Where elements go: one call an element. KiwiTables (GeoPackage, PostGIS) and KiwiCsv stand
/// behind it; a holder of the KIWI+ byte format writes a third (seven tables of correspondence are
/// all that takes: docs/kiwi_plus.md) and feeds it with ReplayKiwiPlus.
///
/// Callers keep the rules: a feature space before its elements, a connector before its attributes,
/// nothing written twice, nothing changed but by Close. Ids are unique within a kind. One thread.
class KiwiPlusWriter {
 public:
  virtual ~KiwiPlusWriter() = default;
  virtual core::Expected<void> Write(const FeatureSpace& space) = 0;
  virtual core::Expected<void> Write(const VectorElement& vector) = 0;
  virtual core::Expected<void> Write(const ConnectorElement& connector) = 0;
  virtual core::Expected<void> Write(const Attribute& attribute) = 0;
  /// The element existed until `end`, exclusive.
  virtual core::Expected<void> Close(ElementKind kind, const std::string& id,
                                     core::UtcTime end) = 0;

  /// Vectors, connector, attributes in this order.
  core::Expected<void> Write(const ElementSet& set);
};

}  // namespace kawara::gis
