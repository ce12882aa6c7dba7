#pragma once
#include <ogr_feature.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "core/time.hpp"

/// Setting and reading a row's columns by name; what is not known is NULL. Inside gis/kiwi only.
namespace kawara::gis {

inline void SetText(OGRFeature& f, const char* name, const std::string& value) {
  if (value.empty()) {
    f.SetFieldNull(f.GetFieldIndex(name));
  } else {
    f.SetField(name, value.c_str());
  }
}

/// For columns that are never NULL: empty is empty.
inline void SetTextAlways(OGRFeature& f, const char* name, const std::string& value) {
  f.SetField(name, value.c_str());
}

inline void SetReal(OGRFeature& f, const char* name, double value) {
  if (std::isfinite(value)) {
    f.SetField(name, value + 0.0);  // minus zero is zero
  } else {
    f.SetFieldNull(f.GetFieldIndex(name));
  }
}

inline void SetInteger(OGRFeature& f, const char* name, std::int64_t value) {
  f.SetField(name, static_cast<GIntBig>(value));
}

/// To the millisecond, cut as IsoUtc cuts.
inline void SetTime(OGRFeature& f, const char* name, core::UtcTime t) {
  const int field = f.GetFieldIndex(name);
  if (!t.IsSet()) {
    f.SetFieldNull(field);
    return;
  }
  const core::CivilTime c = core::ToCivil(t);
  constexpr int kUtcFlag = 100;
  const int ms = c.nanosecond / 1'000'000;
  f.SetField(field, c.year, c.month, c.day, c.hour, c.minute,
             static_cast<float>(c.second) + static_cast<float>(ms) / 1000.0F, kUtcFlag);
}

inline void SetNs(OGRFeature& f, const char* name, core::UtcTime t) {
  if (t.IsSet()) {
    SetInteger(f, name, t.ns());
  } else {
    f.SetFieldNull(f.GetFieldIndex(name));
  }
}

inline bool IsNull(const OGRFeature& f, const char* name) {
  return !f.IsFieldSetAndNotNull(f.GetFieldIndex(name));
}

/// Not set where NULL.
inline core::UtcTime GetNs(const OGRFeature& f, const char* name) {
  if (IsNull(f, name)) return {};
  return core::UtcTime::FromNs(f.GetFieldAsInteger64(name));
}

}  // namespace kawara::gis
