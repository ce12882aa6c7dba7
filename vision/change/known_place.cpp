#include "vision/change/known_place.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace kawara::vision {

core::Expected<KnownPlace> KnownPlace::Of(ReferenceMap reference) {
  if (reference.roads.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "no road to look at: give its area to kawara-reference (--road FILE)");
  auto road = RoadArea::Make(reference.roads);
  if (!road) return tl::unexpected(road.error());
  std::vector<RoadAxis> axes;
  for (const auto& [name, points] : reference.road_axes)
    if (auto axis = AxisAlong(name, points)) axes.push_back(std::move(*axis));
  if (axes.empty()) axes = AxesOf(*road);
  return KnownPlace{std::move(reference), std::move(*road), std::move(axes)};
}

core::Expected<void> KnownPlace::CheckOrigin(const ReferenceMap& reference,
                                             const core::Geodetic& origin) {
  if (!reference.origin) return {};
  const double off_m = core::LocalEnu(origin).FromGeodetic(*reference.origin).norm();
  constexpr double kSame = 0.001;
  if (off_m < kSame) return {};
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(),
                "the reference's map lies elsewhere than the model's (%.3f m apart): make the "
                "reference with --origin %.9f,%.9f,%.4f",
                off_m, origin.lat_rad * core::kDegFromRad, origin.lon_rad * core::kDegFromRad,
                origin.h_ellipsoidal_m);
  return core::Fail(core::ErrorCode::kInvalidArgument, text.data());
}

}  // namespace kawara::vision
