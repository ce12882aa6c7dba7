#include "gis/city/city_surfaces.hpp"

#include "core/iso8601.hpp"

namespace kawara::gis {

core::Expected<CityAxes> CityAxes::Make(const std::string& reference_system,
                                        const MapFrame& frame) {
  CityAxes axes;
  if (frame.coordinates == Coordinates::kLocalMetres) return axes;
  if (reference_system.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "it states no reference system: say that its coordinates are local metres");
  auto crs = CrsToEnu::Make(reference_system, frame);
  if (!crs) return tl::unexpected(crs.error());
  const bool by_authority = reference_system.find("urn:") != std::string::npos ||
                            reference_system.find("/def/crs/") != std::string::npos;
  axes.northing_first_ = by_authority && crs->IsNorthingFirst();
  axes.crs_.emplace(std::move(*crs));
  return axes;
}

Eigen::Vector3d CityAxes::Place(const Eigen::Vector3d& p) {
  if (!crs_) return p;
  const Eigen::Vector3d exchanged(p.y(), p.x(), p.z());
  if (!is_judged_) {
    is_judged_ = true;
    const auto is_near = [this](const Eigen::Vector3d& xyz) {
      return crs_->Exact(xyz).norm() < kFar_m;  // false for NaN
    };
    const bool as_said = is_near(northing_first_ ? exchanged : p);
    if (!as_said && is_near(northing_first_ ? p : exchanged)) northing_first_ = !northing_first_;
  }
  return crs_->Exact(northing_first_ ? exchanged : p);
}

std::optional<core::UtcTime> DateOf(const std::string& text) {
  constexpr std::string_view kFirst = "0000-01-01T00:00:00Z";
  std::string whole = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
  if (whole.size() < kFirst.size() && whole.find('T') == std::string::npos)
    whole += kFirst.substr(whole.size());
  const auto time = core::ParseIso8601(whole);
  if (!time) return std::nullopt;
  return *time;
}

}  // namespace kawara::gis
