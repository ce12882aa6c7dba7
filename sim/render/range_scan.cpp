#include "sim/render/range_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geodesy.hpp"
#include "sim/dice.hpp"
#include "sim/render/surface_pattern.hpp"

namespace kawara::sim {
namespace {

/// Echoes nearer to each other than this melt into one (the pulse is a few metres long; the
/// electronics tell its front edge).
constexpr double kMergedEchoes_m = 0.5;
/// Infrared: what is dark to the eye often is less so; paint and asphalt are not.
constexpr double kInfraredFloor = 0.01;
/// A pane sends a beam back only when it stands square to it [cosine of 6 degrees].
constexpr double kGlassCosine = 0.9945;

struct Echo {
  double range_m = 0.0;
  double strength = 0.0;
};

// Lambert's law: the share that comes back falls with the cosine, and with the range squared.
Echo EchoOf(const RayScene& scene, const RayHit& hit, const Eigen::Vector3d& direction,
            double echo_at_1m, double footprint_m) {
  const Material& material = scene.materials()[hit.material];
  const double cosine = std::abs(hit.normal_enu.cast<double>().dot(direction));
  double reflectance = 0.0;
  if (material.pattern == Pattern::kGlass) {
    reflectance = cosine > kGlassCosine ? 1.0 : 0.004;
  } else {
    SurfacePoint point;
    point.uv_m = hit.uv_m;
    point.footprint_u_m = point.footprint_v_m = static_cast<float>(footprint_m);
    const SurfaceColour colour = ColourOf(material, point);
    // 905 nm: nearest to red; leaves are bright there.
    reflectance = static_cast<double>(material.pattern == Pattern::kLeaves ||
                                              material.pattern == Pattern::kGrass
                                          ? std::max(colour.rgb[0], 0.4F)
                                          : colour.rgb[0]);
  }
  reflectance = std::max(reflectance, kInfraredFloor);
  const double range = std::max(hit.range_m, 0.1);
  return {hit.range_m, echo_at_1m * reflectance * cosine / (range * range)};
}

// What the receiver makes of the echoes of one pulse: groups them, takes the strongest group.
Echo Strongest(std::vector<Echo>& echoes) {
  std::sort(echoes.begin(), echoes.end(),
            [](const Echo& a, const Echo& b) { return a.range_m < b.range_m; });
  Echo best;
  for (std::size_t first = 0; first < echoes.size();) {
    std::size_t last = first;
    Echo group;
    while (last < echoes.size() && echoes[last].range_m - echoes[first].range_m < kMergedEchoes_m) {
      group.range_m += echoes[last].range_m * echoes[last].strength;
      group.strength += echoes[last].strength;
      ++last;
    }
    if (group.strength > best.strength) best = {group.range_m / group.strength, group.strength};
    first = last;
  }
  return best;
}

}  // namespace

int RangeScannerSettings::beam_count() const {
  return static_cast<int>(std::lround(field_deg / step_deg)) + 1;
}

RangeScanner::RangeScanner(const RangeScannerSettings& settings) : settings_(settings) {
  settings_.beam_rays = std::clamp(settings_.beam_rays, 1, kPacketRays);
}

std::vector<RangeBeam> RangeScanner::Scan(
    const RayScene& scene, const std::function<Eigen::Isometry3d(double)>& enu_from_scanner,
    double time_s, std::uint64_t seed) const {
  const RangeScannerSettings& s = settings_;
  const RayScene::Moment moment = scene.MomentAt(time_s);
  Dice dice(seed);
  std::vector<RangeBeam> beams(static_cast<std::size_t>(s.beam_count()));
  std::vector<Echo> echoes;
  std::array<Eigen::Vector3d, kPacketRays> directions;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    RangeBeam& beam = beams[i];
    const double from_ahead_deg = static_cast<double>(i) * s.step_deg - s.field_deg / 2;
    beam.angle_rad = core::kPi / 2 + from_ahead_deg * core::kRadFromDeg;
    beam.time_s = from_ahead_deg / 360.0 * s.mirror_period_s;
    const Eigen::Isometry3d pose = enu_from_scanner(beam.time_s);
    const Eigen::Vector3d ahead(std::cos(beam.angle_rad), std::sin(beam.angle_rad), 0.0);
    const Eigen::Vector3d aside(-ahead.y(), ahead.x(), 0.0);
    RayPacket rays;
    for (int k = 0; k < s.beam_rays; ++k) {
      // The centre, the rest evenly on a circle that halves the beam's area.
      const double turn = 2.0 * core::kPi * k / std::max(1, s.beam_rays - 1);
      const double off = k == 0 ? 0.0 : s.beam_rad / 2 * std::sqrt(0.5);
      const Eigen::Vector3d d =
          ahead + off * (std::cos(turn) * aside + std::sin(turn) * Eigen::Vector3d::UnitZ());
      directions[static_cast<std::size_t>(k)] = (pose.linear() * d).normalized();
      rays.Set(k, pose.translation(), directions[static_cast<std::size_t>(k)]);
    }
    PacketHits hits;
    scene.Intersect(rays, moment, hits);
    beam.true_range_m = std::numeric_limits<double>::infinity();
    echoes.clear();
    for (int k = 0; k < s.beam_rays; ++k) {
      const auto lane = static_cast<std::size_t>(k);
      if (hits.triangle[lane] == kNoTriangle) continue;
      const RayHit hit = scene.Resolve(hits.triangle[lane], hits.range_m[lane], pose.translation(),
                                       directions[lane]);
      if (k == 0) {
        beam.true_range_m = hit.range_m;
        beam.object = hit.object;
      }
      echoes.push_back(EchoOf(scene, hit, directions[lane], s.echo_at_1m / s.beam_rays,
                              std::max(0.001, hit.range_m * s.beam_rad)));
    }
    // Always the same number of dice a beam, so that one beam's fate changes no other's.
    const double noise = dice.Normal();
    const bool dropped = dice.Uniform() <= s.dropout_share;
    const Echo echo = Strongest(echoes);
    beam.echo = !dropped && echo.strength >= 1.0 && echo.range_m < s.max_range_m;
    if (!beam.echo) {
      beam.range_m = s.max_range_m;
      continue;
    }
    beam.range_m = echo.range_m + noise * std::hypot(s.noise_m, s.noise_share * echo.range_m);
    if (s.resolution_m > 0.0) {
      beam.range_m = std::round(beam.range_m / s.resolution_m) * s.resolution_m;
    }
    beam.range_m = std::clamp(beam.range_m, 0.0, s.max_range_m);
  }
  return beams;
}

}  // namespace kawara::sim
