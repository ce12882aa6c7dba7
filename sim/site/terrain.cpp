#include "sim/site/terrain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/site/seeds.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBeyond_m = 500.0;  ///< the land runs on past the detailed part
constexpr double kRoadStep_m = 1.0;
constexpr double kKerbLean_m = 0.03;
constexpr double kLineWidth_m = 0.15;
constexpr double kEdgeLineFromKerb_m = 0.35;
constexpr double kFade_m = 25.0;  ///< undulation ends within this, inside the detailed part
constexpr double kSliver_m2 = 1e-6;

/// Lines every cell_m inside, doubling steps outside.
std::vector<double> GridLines(double low_m, double high_m, double cell_m) {
  const int cells = static_cast<int>(std::ceil((high_m - low_m) / cell_m - 1e-9));
  std::vector<double> lines;
  for (int i = 0; i <= cells; ++i) lines.push_back(low_m + (high_m - low_m) * i / cells);
  double step = 2.0 * cell_m;
  for (double d = step; d < kBeyond_m; step = std::min(2.0 * step, 100.0), d += step) {
    lines.push_back(high_m + d);
    lines.insert(lines.begin(), low_m - d);
  }
  return lines;
}

double SmoothStep(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

std::size_t Interval(const std::vector<double>& lines, double x) {
  const auto above = std::upper_bound(lines.begin(), lines.end(), x);
  const auto i = std::distance(lines.begin(), above) - 1;
  return static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(i, 0, static_cast<std::ptrdiff_t>(lines.size()) - 2));
}

/// A column line of the road's cross-section, left positive. Between it and the next one to the
/// right lies `part`.
struct Column {
  double offset_m;
  double height_m;  ///< over the gutter; NaN: the land's own height
  GroundPart part;
  bool dashed = false;  ///< a marking that is interrupted along the road
  bool rough = false;
};

std::vector<Column> CrossSection(const RoadConfig& road) {
  const double half = road.width_m / 2.0;
  const double kerb = road.kerb_height_m;
  const double fall = road.crown_percent / 100.0;
  const auto lane = [&](double offset, GroundPart part, bool dashed = false) {
    return Column{offset, fall * (half - std::abs(offset)), part, dashed, true};
  };
  std::vector<Column> left;  // from the kerb to the middle, left side
  const double line_out = half - kEdgeLineFromKerb_m;
  const bool edge = road.edge_lines && line_out - kLineWidth_m > kLineWidth_m;
  left.push_back({half, 0.0, GroundPart::kRoad});
  if (edge) {
    left.push_back(lane(line_out, GroundPart::kMarking));
    left.push_back(lane(line_out - kLineWidth_m, GroundPart::kRoad));
  }
  const int lanes = std::max(1, static_cast<int>(std::lround(half / 1.2)));
  const double from = left.back().offset_m;
  for (int i = 1; i < lanes; ++i)
    left.push_back(lane(from * (lanes - i) / lanes, GroundPart::kRoad));
  std::vector<Column> all;
  const double back = half + (kerb > 0 ? road.kerb_width_m : 0.0) + road.pavement_m;
  all.push_back({road.OuterHalfWidth(), std::nan(""), GroundPart::kLand});
  constexpr double kPavementFall = 0.01;
  const double back_height = kerb + kPavementFall * road.pavement_m;
  if (road.pavement_m > 0) all.push_back({back, back_height, GroundPart::kPavement});
  if (kerb > 0) {
    all.push_back({half + road.kerb_width_m, kerb, GroundPart::kKerbLeft});
    all.push_back({half + kKerbLean_m, kerb, GroundPart::kKerbLeft});
  }
  all.insert(all.end(), left.begin(), left.end());
  if (road.centre_line) {
    all.push_back(lane(kLineWidth_m / 2.0, GroundPart::kMarking, true));
    all.push_back(lane(-kLineWidth_m / 2.0, GroundPart::kRoad));
  } else {
    all.push_back(lane(0.0, GroundPart::kRoad));
  }
  // The right side mirrors the left: each column carries the part that lay on its left's far side.
  const std::size_t mirrored = all.size() - (road.centre_line ? 2 : 1);
  for (std::size_t i = mirrored; i-- > 0;) {
    Column column = all[i];
    column.offset_m = -column.offset_m;
    column.part = i > 0 ? all[i - 1].part : GroundPart::kLand;
    if (column.part == GroundPart::kKerbLeft) column.part = GroundPart::kKerbRight;
    all.push_back(column);
  }
  return all;
}

}  // namespace

Terrain::Terrain(const SiteConfig& site)
    : config_(site.terrain),
      east_lines_m_(GridLines(config_.west_m, config_.east_m, config_.cell_m)),
      north_lines_m_(GridLines(config_.south_m, config_.north_m, config_.cell_m)),
      road_(RoadStations(site.road, kRoadStep_m, kBeyond_m)),
      cells_((east_lines_m_.size() - 1) * (north_lines_m_.size() - 1)) {
  Dice dice = DiceFor(site.seed, "terrain");
  constexpr int kWaves = 5;
  for (int i = 0; i < kWaves; ++i) {
    const double length = config_.undulation_length_m * (0.6 + 0.8 * dice.Uniform());
    const double way = 2.0 * core::kPi * dice.Uniform();
    waves_.push_back({Vector2d(std::cos(way), std::sin(way)) * (2.0 * core::kPi / length),
                      2.0 * core::kPi * dice.Uniform(), config_.undulation_m / std::sqrt(kWaves)});
  }
  LayRoad(site);
  LayLand(site.road);
}

double Terrain::LandHeight(const Vector2d& at) const {
  const double inside = std::min({at.x() - config_.west_m, config_.east_m - at.x(),
                                  at.y() - config_.south_m, config_.north_m - at.y()});
  double height =
      at.x() * config_.slope_east_percent / 100.0 + at.y() * config_.slope_north_percent / 100.0;
  double waves = 0.0;
  for (const Wave& wave : waves_)
    waves += wave.amplitude_m * std::sin(wave.k_per_m.dot(at) + wave.phase_rad);
  return height + waves * SmoothStep(inside / kFade_m);
}

void Terrain::Add(const Vector3d& a, const Vector3d& b, const Vector3d& c, GroundPart part) {
  const Vector2d ab = (b - a).head<2>();
  const Vector2d ac = (c - a).head<2>();
  if ((ab.x() * ac.y() - ab.y() * ac.x()) / 2.0 < kSliver_m2) return;
  const auto index = static_cast<std::uint32_t>(triangles_.size());
  triangles_.push_back({{a.cast<float>(), b.cast<float>(), c.cast<float>()}, part});
  const Vector3d low = a.cwiseMin(b).cwiseMin(c);
  const Vector3d high = a.cwiseMax(b).cwiseMax(c);
  constexpr double kRound_m = 1e-4;  // corners are rounded to 32 bits
  const std::size_t columns = east_lines_m_.size() - 1;
  for (std::size_t j = Interval(north_lines_m_, low.y() - kRound_m);
       j <= Interval(north_lines_m_, high.y() + kRound_m); ++j) {
    for (std::size_t i = Interval(east_lines_m_, low.x() - kRound_m);
         i <= Interval(east_lines_m_, high.x() + kRound_m); ++i)
      cells_[j * columns + i].push_back(index);
  }
}

void Terrain::LayRoad(const SiteConfig& site) {
  const std::vector<Column> columns = CrossSection(site.road);
  Dice dice = DiceFor(site.seed, "road");
  std::vector<std::vector<Vector3d>> rows;
  for (const RoadStation& station : road_) {
    const double gutter = LandHeight(station.middle_m) - site.road.kerb_height_m;
    std::vector<Vector3d> row;
    row.reserve(columns.size());
    for (const Column& column : columns) {
      const Vector2d at = station.middle_m + station.left * column.offset_m;
      const double rough = (2.0 * dice.Uniform() - 1.0) * site.road.roughness_m;
      const double height = std::isnan(column.height_m)
                                ? LandHeight(at)
                                : gutter + column.height_m + (column.rough ? rough : 0.0);
      row.emplace_back(at.x(), at.y(), height);
    }
    rows.push_back(std::move(row));
  }
  constexpr double kDash_m = 10.0;  // half of it painted
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    const double along = (road_[i].along_m + road_[i + 1].along_m) / 2.0;
    const bool painted = along - kDash_m * std::floor(along / kDash_m) < kDash_m / 2.0;
    for (std::size_t k = 0; k + 1 < columns.size(); ++k) {
      const Vector3d &a = rows[i][k + 1], &b = rows[i + 1][k + 1];
      const Vector3d &c = rows[i + 1][k], &d = rows[i][k];
      const GroundPart part = columns[k].dashed && !painted ? GroundPart::kRoad : columns[k].part;
      Add(a, b, c, part);
      Add(a, c, d, part);
    }
  }
}

/// The grid, minus the road's corridor: each corridor quad is cut out of the triangles it touches,
/// and what is left lies in the plane of its triangle, so nothing gapes.
void Terrain::LayLand(const RoadConfig& road) {
  const double outer = road.OuterHalfWidth();
  const std::size_t columns = east_lines_m_.size() - 1;
  std::vector<std::vector<std::uint32_t>> road_in_cell(cells_.size());
  std::vector<std::array<Vector2d, 4>> quads;
  for (std::size_t i = 0; i + 1 < road_.size(); ++i) {
    const RoadStation &p = road_[i], &q = road_[i + 1];
    quads.push_back({p.middle_m - p.left * outer, q.middle_m - q.left * outer,
                     q.middle_m + q.left * outer, p.middle_m + p.left * outer});
    const auto& quad = quads.back();
    const Vector2d low = quad[0].cwiseMin(quad[1]).cwiseMin(quad[2]).cwiseMin(quad[3]);
    const Vector2d high = quad[0].cwiseMax(quad[1]).cwiseMax(quad[2]).cwiseMax(quad[3]);
    for (std::size_t n = Interval(north_lines_m_, low.y()); n <= Interval(north_lines_m_, high.y());
         ++n)
      for (std::size_t e = Interval(east_lines_m_, low.x()); e <= Interval(east_lines_m_, high.x());
           ++e)
        road_in_cell[n * columns + e].push_back(static_cast<std::uint32_t>(i));
  }
  const auto corner = [&](std::size_t i, std::size_t j) {
    const Vector2d at(east_lines_m_[i], north_lines_m_[j]);
    return Vector3d(at.x(), at.y(), LandHeight(at));
  };
  for (std::size_t j = 0; j + 1 < north_lines_m_.size(); ++j) {
    for (std::size_t i = 0; i + 1 < east_lines_m_.size(); ++i) {
      const Vector3d sw = corner(i, j), se = corner(i + 1, j);
      const Vector3d ne = corner(i + 1, j + 1), nw = corner(i, j + 1);
      for (const auto& t : {std::array{sw, se, ne}, std::array{sw, ne, nw}}) {
        std::vector<std::vector<Vector2d>> pieces{{t[0].head<2>(), t[1].head<2>(), t[2].head<2>()}};
        for (std::uint32_t q : road_in_cell[j * columns + i]) {
          std::vector<std::vector<Vector2d>> left;
          for (std::vector<Vector2d>& piece : pieces) {
            std::vector<Vector2d> rest = piece;
            std::vector<std::vector<Vector2d>> outside;
            for (std::size_t s = 0; s < 4 && rest.size() >= 3; ++s) {
              const Vector2d &a = quads[q][s], &b = quads[q][(s + 1) % 4];
              outside.push_back(CutLeft(rest, b, a));
              rest = CutLeft(rest, a, b);
            }
            if (rest.size() < 3 || SignedArea(rest) < kSliver_m2) {
              outside.assign(1, piece);  // the quad missed this piece: it stays whole
            }
            for (std::vector<Vector2d>& o : outside)
              if (o.size() >= 3 && SignedArea(o) >= kSliver_m2) left.push_back(std::move(o));
          }
          pieces = std::move(left);
        }
        const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
        const auto lift = [&](const Vector2d& p) {
          return Vector3d(
              p.x(), p.y(),
              t[0].z() -
                  (normal.x() * (p.x() - t[0].x()) + normal.y() * (p.y() - t[0].y())) / normal.z());
        };
        for (const std::vector<Vector2d>& piece : pieces)
          for (std::size_t k = 2; k < piece.size(); ++k)
            Add(lift(piece[0]), lift(piece[k - 1]), lift(piece[k]), GroundPart::kLand);
      }
    }
  }
}

std::size_t Terrain::CellOf(double east_m, double north_m) const {
  return Interval(north_lines_m_, north_m) * (east_lines_m_.size() - 1) +
         Interval(east_lines_m_, east_m);
}

namespace {

/// Shares of the corners of a triangle at a place; the smallest is negative outside.
Vector3d Shares(const Terrain::Triangle& t, double east_m, double north_m) {
  const Vector2d a = t.corners_m[0].cast<double>().head<2>();
  const Vector2d ab = t.corners_m[1].cast<double>().head<2>() - a;
  const Vector2d ac = t.corners_m[2].cast<double>().head<2>() - a;
  const Vector2d ap = Vector2d(east_m, north_m) - a;
  const double area = ab.x() * ac.y() - ab.y() * ac.x();
  const double b = (ap.x() * ac.y() - ap.y() * ac.x()) / area;
  const double c = (ab.x() * ap.y() - ab.y() * ap.x()) / area;
  return {1.0 - b - c, b, c};
}

}  // namespace

std::uint32_t Terrain::TriangleAt(double east_m, double north_m) const {
  std::uint32_t best = 0;
  double best_share = -std::numeric_limits<double>::infinity();
  for (std::uint32_t i : cells_[CellOf(east_m, north_m)]) {
    const double share = Shares(triangles_[i], east_m, north_m).minCoeff();
    if (share > best_share) {
      best_share = share;
      best = i;
    }
    if (share >= 0) break;
  }
  return best;
}

double Terrain::GroundHeight(double east_m, double north_m) const {
  const double east = std::clamp(east_m, east_lines_m_.front(), east_lines_m_.back());
  const double north = std::clamp(north_m, north_lines_m_.front(), north_lines_m_.back());
  const Triangle& t = triangles_[TriangleAt(east, north)];
  const Vector3d share = Shares(t, east, north);
  return share.x() * static_cast<double>(t.corners_m[0].z()) +
         share.y() * static_cast<double>(t.corners_m[1].z()) +
         share.z() * static_cast<double>(t.corners_m[2].z());
}

GroundPart Terrain::PartAt(double east_m, double north_m) const {
  return triangles_[TriangleAt(east_m, north_m)].part;
}

std::array<double, 2> Terrain::HeightRange(const std::vector<Vector2d>& polygon) const {
  std::array<double, 2> range{std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d side = polygon[(i + 1) % polygon.size()] - polygon[i];
    const int steps = 1 + static_cast<int>(side.norm());
    for (int s = 0; s < steps; ++s) {
      const Vector2d at = polygon[i] + side * s / steps;
      const double height = GroundHeight(at.x(), at.y());
      range = {std::min(range[0], height), std::max(range[1], height)};
    }
  }
  return range;
}

}  // namespace kawara::sim
