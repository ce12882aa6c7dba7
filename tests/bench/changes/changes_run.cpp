// bench_changes_run SITE SEED PICTURES COLUMNS [plain|fine|hard|offset|far|none|paper [FOLDER]]:
// one drive past one made street, judged against the truth; one line of JSON. What the words mean
// stands in changes_bench.py. The sides' textures go into the folder, beside what they should look
// like.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "sim/evaluate/upright_boxes.hpp"
#include "tests/bench/changes/change_drive.hpp"
#include "tests/bench/changes/judge_textures.hpp"
#include "vision/change/align_reference.hpp"
#include "vision/change/change_finder.hpp"

namespace kawara::change_bench {
namespace {

double CpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Shared over joint area seen from above.
double FlatOverlap(core::UprightBox a, core::UprightBox b) {
  a.centre_m.z() = b.centre_m.z() = 0.0;
  a.size_m.z() = b.size_m.z() = 1.0;
  return sim::IntersectionOverUnion({"", "", a.Apexes()}, {"", "", b.Apexes()});
}

/// Of found voxels those within 0.3 m of a changed surface; of changed surfaces that could be seen,
/// higher than what counts, those within 0.2 m of a found voxel.
void JudgeVoxels(const ChangeDrive& drive, const vision::Findings& found, double voxel_m) {
  std::size_t all = 0, right = 0, samples = 0, met = 0;
  for (const auto& change : found.changes)
    for (std::size_t i = 0; i < change.region.points.size(); i += 3) {
      ++all;
      right += drive.DistanceToChange(change.region.points[i].position_m) < 0.3 ? 1U : 0U;
    }
  constexpr double kCounts = 0.4, kNear = 0.2;
  const std::size_t step = drive.change_samples().size() / 1500 + 1;
  for (std::size_t i = 0; i < drive.change_samples().size(); i += step) {
    const Eigen::Vector3d& s = drive.change_samples()[i];
    if (s.z() - drive.terrain().GroundHeight(s.x(), s.y()) < kCounts) continue;
    ++samples;
    const auto near = [&](const vision::ChangePoint& p) {
      return (p.position_m - s).norm() < std::max(kNear, voxel_m);
    };
    met += std::any_of(found.changes.begin(), found.changes.end(), [&](const auto& change) {
      return std::any_of(change.region.points.begin(), change.region.points.end(), near);
    });
  }
  std::printf("\"precision\": %.4f, \"recall\": %.4f, ",
              all > 0 ? static_cast<double>(right) / static_cast<double>(all) : 1.0,
              samples > 0 ? static_cast<double>(met) / static_cast<double>(samples) : 1.0);
}

void JudgeBoxes(const ChangeDrive& drive, const vision::Findings& found) {
  std::vector<bool> used(found.changes.size(), false);
  std::printf("\"boxes\": [");
  bool first = true;
  for (const TrueObject& truth : drive.truth()) {
    double best = 0.0;
    std::size_t which = found.changes.size();
    for (std::size_t i = 0; i < found.changes.size(); ++i) {
      const double overlap = FlatOverlap(truth.box, found.changes[i].object.box);
      if (!used[i] && overlap > best) {
        best = overlap;
        which = i;
      }
    }
    if (which == found.changes.size()) continue;
    used[which] = true;
    const core::ChangedObject& object = found.changes[which].object;
    const Eigen::Vector3d size = object.box.size_m - truth.box.size_m;
    const Eigen::Vector3d centre = object.box.centre_m - truth.box.centre_m;
    const double heading =
        core::WrapPi(2.0 * (object.box.heading_rad - truth.box.heading_rad)) / 2.0;
    std::printf(
        "%s{\"name\": \"%s\", \"iou\": %.4f, \"centre\": %.4f, \"size\": [%.4f, %.4f, %.4f], "
        "\"heading_deg\": %.4f, \"z\": [",
        first ? "" : ", ", truth.name.c_str(), best, centre.head<2>().norm(), size.x(), size.y(),
        size.z(), heading * core::kDegFromRad);
    const double off[] = {centre.x(), centre.y(), centre.z(), size.x(),
                          size.y(),   size.z(),   heading};
    // The paper's boxes state no deviation.
    for (int i = 0; i < 7 && object.covariance(i, i) > 0.0; ++i)
      std::printf("%s%.3f", i == 0 ? "" : ", ", off[i] / std::sqrt(object.covariance(i, i)));
    std::printf("]}");
    first = false;
  }
  std::printf("], \"false\": %td, ", std::count(used.begin(), used.end(), false));
}

/// The road left at the stations that the drive passed, against that of the true boxes.
void JudgeWidth(const ChangeDrive& drive, const vision::Findings& found,
                const vision::RoadArea& road, const vision::RoadAxis& axis) {
  std::vector<vision::Obstacle> truth;
  for (const TrueObject& object : drive.truth()) truth.push_back({object.box, 0.0});
  const auto exact = vision::MeasureWidth(road, axis, truth, found.look, {});
  std::printf("\"width\": [");
  bool first = true;
  for (std::size_t i = 0; i < exact.size() && i < found.stations.size(); ++i) {
    const core::RoadStation& station = found.stations[i];
    const double narrowed = exact[i].road_width_m - exact[i].passable_m;
    if (station.unknown_share > 0.5 || narrowed < 0.3) continue;
    std::printf("%s[%.3f, %.3f]", first ? "" : ", ", station.passable_m - exact[i].passable_m,
                station.passable_sd_m);
    first = false;
  }
  std::printf("], ");
}

int Main(const ChangeDrive::Options& options, const std::string& kind, const std::string& folder) {
  Errors errors = kind == "hard" ? Errors::Hard() : Errors{};
  if (kind == "offset") {
    errors.offset_m = {0.06, 0.08, 0.0};
    errors.offset_heading_rad = 0.3 * core::kRadFromDeg;
  }
  if (kind == "far") errors.offset_m = {0.30, 0.40, 0.0};
  const ChangeDrive drive(options);
  const vision::RoadArea road = drive.Road();
  const vision::KnownPlace place{drive.Reference(), road, vision::AxesOf(road)};
  auto map = vision::VoxelMap::Create({.voxel_m = kind == "fine" ? 0.1 : 0.2});
  if (!map || place.axes.empty()) return 2;
  double vote_s = 0.0, examine_s = 0.0;
  for (int i = 0; i < drive.pictures(); ++i) {
    const Picture picture = drive.Take(i, errors, options.seed);
    const vision::RangeView view{drive.rays(), picture.ranges, {}, picture.map_from_camera,
                                 0.03,         0.00175};
    const double start = CpuSeconds();
    if (!map->Vote(view)) return 2;
    const double voted = CpuSeconds();
    if (!map->Examine(view)) return 2;
    examine_s += CpuSeconds() - voted;
    vote_s += voted - start;
  }
  vision::FinderOptions finder = kind == "paper" ? vision::PaperFinder() : vision::FinderOptions{};
  const double start = CpuSeconds();
  const auto alignment = vision::AlignReference(*map, place, finder.change.rule, {});
  const double aligned = CpuSeconds();
  if (!alignment) {
    std::printf("{\"refused\": true, \"reason\": \"%s\"}\n", alignment.error().message.c_str());
    return 0;
  }
  finder.width.fit_covariance_m2 = alignment->plane_covariance_m2;
  const vision::Findings found =
      vision::FindChanges(*map, place, alignment->reference_from_map, finder);
  const double done = CpuSeconds();
  std::printf("{\"refused\": false, ");
  JudgeVoxels(drive, found, map->config().voxel_m);
  JudgeBoxes(drive, found);
  JudgeWidth(drive, found, road, place.axes.front());
  const auto sides = JudgeTextures(drive, errors, options.seed, found, folder);
  if (!sides) {
    std::fprintf(stderr, "bench_changes: %s\n", sides.error().message.c_str());
    return 2;
  }
  std::printf("\"sides\": [");
  for (std::size_t i = 0; i < sides->size(); ++i) {
    const JudgedSide& side = (*sides)[i];
    std::printf(
        "%s{\"uid\": \"%s\", \"side\": \"%s\", \"seen\": %.3f, \"correlation\": %.4f, "
        "\"aligned\": %.4f, \"off_px\": %.2f, \"texel_m\": %.4f, \"make_s\": %.4f, \"kb\": %.1f}",
        i == 0 ? "" : ", ", side.uid.c_str(), core::ToString(side.side), side.seen_share,
        side.correlation, side.aligned, side.off_px, side.texel_m, side.make_s, side.atlas_kb);
  }
  std::printf("], ");
  std::printf(
      "\"truth\": %zu, \"shift\": [%.3f, %.3f, %.3f], \"votes\": %llu, \"vote_s\": %.3f, "
      "\"examine_s\": %.3f, \"align_s\": %.3f, \"find_s\": %.3f, \"map_mb\": %.1f}\n",
      drive.truth().size(), alignment->shift_m.x(), alignment->shift_m.y(), alignment->shift_m.z(),
      static_cast<unsigned long long>(map->counts().votes), vote_s, examine_s, aligned - start,
      done - aligned, 1e-6 * static_cast<double>(map->memory_bytes()));
  return 0;
}

}  // namespace
}  // namespace kawara::change_bench

int main(int count, char** words) {
  if (count < 5) {
    std::fprintf(stderr, "usage: bench_changes_run SITE SEED PICTURES COLUMNS [KIND [FOLDER]]\n");
    return 2;
  }
  kawara::change_bench::ChangeDrive::Options options;
  options.site = words[1];
  options.seed = static_cast<std::uint64_t>(std::atoll(words[2]));
  options.pictures = std::atoi(words[3]);
  options.columns = std::atoi(words[4]);
  const std::string kind = count > 5 ? words[5] : "";
  options.vehicles = kind != "none";
  return kawara::change_bench::Main(options, kind, count > 6 ? words[6] : "");
}
