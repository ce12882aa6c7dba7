#include "sim/evaluate/upright_boxes.hpp"

#include <algorithm>
#include <cmath>

#include "sim/evaluate/table.hpp"

namespace kawara::sim {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double SignedArea(const Polygon& p) {
  double twice = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) twice += Cross(p[i], p[(i + 1) % p.size()]);
  return twice / 2.0;
}

/// Counter-clockwise footprint.
Polygon Footprint(const ApexBox& box) {
  Polygon p;
  for (std::size_t i = 0; i < 4; ++i) p.emplace_back(box.apexes_enu_m[i].head<2>());
  if (SignedArea(p) < 0) std::reverse(p.begin(), p.end());
  return p;
}

/// What of `p` lies left of the line a -> b (Sutherland and Hodgman's step).
Polygon LeftOf(const Polygon& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  Polygon kept;
  const auto side = [&](const Eigen::Vector2d& q) { return Cross(b - a, q - a); };
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Eigen::Vector2d& from = p[i];
    const Eigen::Vector2d& to = p[(i + 1) % p.size()];
    const double s_from = side(from), s_to = side(to);
    if (s_from >= 0) kept.push_back(from);
    if ((s_from > 0 && s_to < 0) || (s_from < 0 && s_to > 0)) {
      kept.emplace_back(from + (to - from) * (s_from / (s_from - s_to)));
    }
  }
  return kept;
}

double SharedArea(const ApexBox& a, const ApexBox& b) {
  Polygon shared = Footprint(a);
  const Polygon cutter = Footprint(b);
  for (std::size_t i = 0; i < cutter.size() && shared.size() >= 3; ++i) {
    shared = LeftOf(shared, cutter[i], cutter[(i + 1) % cutter.size()]);
  }
  return shared.size() < 3 ? 0.0 : std::abs(SignedArea(shared));
}

double Bottom(const ApexBox& box) { return box.apexes_enu_m[0].z(); }
double Top(const ApexBox& box) { return box.apexes_enu_m[4].z(); }
double Volume(const ApexBox& box) {
  return std::abs(SignedArea(Footprint(box))) * (Top(box) - Bottom(box));
}

core::Expected<Table> ReadBoxTable(const std::string& path) {
  auto table = Table::Read(path, {"changed_object", "kp_box", "object", "objects"});
  if (!table) return table;
  if (const auto id = table->ColumnOf({"id", "object_uid"}); !id) return tl::unexpected(id.error());
  for (int i = 0; i < 8; ++i) {
    const std::string n = std::to_string(i);
    for (const std::string& name :
         {"apex" + n + "_lon_deg", "apex" + n + "_lat_deg", "apex" + n + "_h_m"}) {
      if (const auto column = table->ColumnOf({name}); !column) {
        return tl::unexpected(column.error());
      }
    }
  }
  return table;
}

core::Geodetic ApexOf(const Table& table, std::size_t row, std::size_t apex) {
  const std::string n = std::to_string(apex);
  return {table.Number(row, "apex" + n + "_lat_deg") * core::kRadFromDeg,
          table.Number(row, "apex" + n + "_lon_deg") * core::kRadFromDeg,
          table.Number(row, "apex" + n + "_h_m")};
}

}  // namespace

Eigen::Vector3d ApexBox::Centre() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& apex : apexes_enu_m) sum += apex;
  return sum / 8.0;
}

Eigen::Vector3d ApexBox::Size() const {
  const double a = (apexes_enu_m[1] - apexes_enu_m[0]).head<2>().norm();
  const double b = (apexes_enu_m[2] - apexes_enu_m[1]).head<2>().norm();
  return {std::max(a, b), std::min(a, b), Top(*this) - Bottom(*this)};
}

double ApexBox::Heading() const {
  const Eigen::Vector2d a = (apexes_enu_m[1] - apexes_enu_m[0]).head<2>();
  const Eigen::Vector2d b = (apexes_enu_m[2] - apexes_enu_m[1]).head<2>();
  const Eigen::Vector2d along = a.norm() >= b.norm() ? a : b;
  const double heading = std::atan2(along.x(), along.y());
  return heading < 0 ? heading + core::kPi : (heading >= core::kPi ? heading - core::kPi : heading);
}

double IntersectionOverUnion(const ApexBox& a, const ApexBox& b) {
  const double shared_height = std::min(Top(a), Top(b)) - std::max(Bottom(a), Bottom(b));
  if (shared_height <= 0) return 0.0;
  const double shared = SharedArea(a, b) * shared_height;
  const double joint = Volume(a) + Volume(b) - shared;
  return joint > 0 ? shared / joint : 0.0;
}

core::Expected<std::vector<ApexBox>> ReadBoxes(const std::string& path,
                                               const core::LocalEnu& plane) {
  const auto table = ReadBoxTable(path);
  if (!table) return tl::unexpected(table.error());
  const std::string id = *table->ColumnOf({"id", "object_uid"});
  const std::string cls = table->ColumnOf({"class", "class_code"}).value_or("");
  const std::string end = table->ColumnOf({"t_end"}).value_or("");
  std::vector<ApexBox> boxes;
  for (std::size_t row = 0; row < table->size(); ++row) {
    if (!end.empty() && !table->Text(row, end).empty()) continue;  // history, or gone
    ApexBox box;
    box.id = table->Text(row, id);
    if (!cls.empty()) box.cls = table->Text(row, cls);
    for (std::size_t i = 0; i < 8; ++i) {
      box.apexes_enu_m[i] = plane.FromGeodetic(ApexOf(*table, row, i));
      if (!box.apexes_enu_m[i].allFinite()) {
        return core::Fail(core::ErrorCode::kFormat, path + ": box " + box.id + ": apex " +
                                                        std::to_string(i) + " is no place");
      }
    }
    boxes.push_back(std::move(box));
  }
  return boxes;
}

core::Expected<core::Geodetic> PlaceOfBoxes(const std::string& path) {
  const auto table = ReadBoxTable(path);
  if (!table) return tl::unexpected(table.error());
  if (table->size() == 0) return core::Fail(core::ErrorCode::kFormat, path + ": no box in it");
  return ApexOf(*table, 0, 0);
}

}  // namespace kawara::sim
