#include "gis/kiwi/check_object.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>

#include "core/geodesy.hpp"
#include "gis/record_check.hpp"

namespace kawara::gis {
namespace {

constexpr std::uint64_t kMaxCount = std::numeric_limits<std::int64_t>::max();
/// Variances of a matrix that was computed differ across the diagonal by rounding only.
constexpr double kAsymmetry = 1e-9;
constexpr double kMaxCoordinateM = 1e6;
constexpr double kMaxSizeM = 1e4;

bool IsUid(const std::string& uid) {
  return !uid.empty() && uid.size() <= kMaxNameBytes && uid.front() != '.' &&
         std::all_of(uid.begin(), uid.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
         });
}

bool IsShare(double value) { return value >= 0.0 && value <= 1.0; }

bool IsTime(core::UtcTime t) {
  static const core::UtcTime kFrom = core::FromCivil({2000, 1, 1, 0, 0, 0, 0});
  static const core::UtcTime kUntil = core::FromCivil({2200, 1, 1, 0, 0, 0, 0});
  return t >= kFrom && t < kUntil;
}

bool IsBox(const core::UprightBox& box) {
  return box.centre_m.allFinite() && box.centre_m.cwiseAbs().maxCoeff() <= kMaxCoordinateM &&
         box.size_m.allFinite() && box.size_m.minCoeff() > 0.0 &&
         box.size_m.maxCoeff() <= kMaxSizeM && std::isfinite(box.heading_rad) &&
         std::abs(box.heading_rad) <= 4.0 * core::kPi;
}

bool IsCovariance(const decltype(core::ChangedObject::covariance)& c) {
  if (!c.allFinite() || c.diagonal().minCoeff() < 0.0) return false;
  return (c - c.transpose()).cwiseAbs().maxCoeff() <= kAsymmetry * c.cwiseAbs().maxCoeff();
}

bool AreRobots(const std::vector<std::string>& robots) {
  std::set<std::string> seen;
  return std::all_of(robots.begin(), robots.end(), [&seen](const std::string& robot) {
    return !robot.empty() && IsCleanText(robot, kMaxNameBytes) &&
           robot.find(',') == std::string::npos && seen.insert(robot).second;
  });
}

/// What is wrong with an object; null: nothing.
const char* Fault(const core::ChangedObject& o) {
  if (o.revision == 0 || o.revision > kMaxCount) return "revision: they count from 1";
  if (!IsBox(o.box)) return "box: not finite, without volume or out of the map";
  if (!IsCovariance(o.covariance)) return "covariance: not finite, not symmetric or negative";
  if (o.second_heading_rad && !(std::abs(*o.second_heading_rad) <= 4.0 * core::kPi))
    return "second heading: no angle";
  if (!IsShare(o.existence_probability)) return "existence probability: outside of 0..1";
  if (!IsShare(o.class_probability)) return "class probability: outside of 0..1";
  if (o.votes > kMaxCount) return "votes: too many";
  if (!IsTime(o.first_seen) || !IsTime(o.last_seen) || o.last_seen < o.first_seen)
    return "first and last seen: not set, not in 2000..2200 or not in this order";
  if (o.last_absent.IsSet() && (!IsTime(o.last_absent) || o.last_absent > o.first_seen))
    return "last absent: after it was first seen, or not in 2000..2200";
  if ((o.state == core::ChangeState::kGone) != o.gone.IsSet())
    return "gone: set without the state, or the state without the time";
  if (o.gone.IsSet() && (!IsTime(o.gone) || o.gone < o.first_seen))
    return "gone: before it was first seen, or not in 2000..2200";
  if (!AreRobots(o.robots)) return "robots: names of 1..64 clean bytes without comma, each once";
  return nullptr;
}

const char* Fault(const core::RoadStation& s) {
  if (s.road.empty() || !IsCleanText(s.road, kMaxNameBytes)) return "the road's name";
  for (const double value : {s.along_m, s.road_width_m, s.passable_m, s.passable_sd_m,
                             s.gap_begin_m, s.gap_end_m, s.unknown_share}) {
    if (!std::isfinite(value)) return "a figure that is none";
  }
  for (const Eigen::Vector3d& edge : {s.left_m, s.right_m}) {
    if (!edge.allFinite() || edge.cwiseAbs().maxCoeff() > kMaxCoordinateM)
      return "an edge out of the map";
  }
  if (s.left_m == s.right_m) return "edges that are one";
  if (!IsShare(s.unknown_share)) return "an unknown share outside of 0..1";
  if (s.observed.IsSet() && !IsTime(s.observed)) return "a time not in 2000..2200";
  return nullptr;
}

}  // namespace

core::Expected<void> CheckObject(const core::ChangedObject& object) {
  if (!IsUid(object.uid))
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "changed object: its uid must be 1..64 of A-Z a-z 0-9 . _ - and not begin "
                      "with a dot");
  if (const char* fault = Fault(object))
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "changed object " + object.uid + ": " + fault);
  return {};
}

core::Expected<void> CheckStation(const core::RoadStation& station) {
  if (const char* fault = Fault(station))
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "road station at " + std::to_string(station.along_m) + " m: has " + fault);
  return {};
}

core::Expected<void> CheckTextures(const core::ObjectTextures& textures) {
  const auto wrong = [](const std::string& what) {
    return core::Fail(core::ErrorCode::kInvalidArgument, "textures: " + what);
  };
  if (textures.atlas_jpeg.empty()) {
    if (!textures.faces.empty()) return wrong("sides without a picture");
    return {};
  }
  if (textures.atlas_jpeg.size() > kMaxJpegBytes) return wrong("the picture is too large");
  const auto size = CheckJpeg(textures.atlas_jpeg);
  if (!size) return wrong(size.error().message);
  if (size->width != textures.width_px || size->height != textures.height_px)
    return wrong("the picture is not of the size stated");
  std::set<core::BoxSide> seen;
  for (const core::FaceTexture& face : textures.faces) {
    if (static_cast<std::size_t>(face.side) >= core::kBoxSides || !seen.insert(face.side).second)
      return wrong("a side named twice, or none");
    for (const auto& [x, y] : face.corners_px) {
      if (!(x >= 0.0 && x <= textures.width_px && y >= 0.0 && y <= textures.height_px))
        return wrong("a corner outside of the picture");
    }
    if (!IsCleanText(face.source, kMaxTextBytes)) return wrong("the name of a source");
    if (!IsShare(face.seen_share)) return wrong("a seen share outside of 0..1");
  }
  return {};
}

}  // namespace kawara::gis
