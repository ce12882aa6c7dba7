// bench_stereo_poses SEEDS: what poses with noise cost stereo, and what their refinement on the
// pictures brings. A drive of rendered pictures every quarter of a metre; poses with white noise of
// 2 cm and 0.1 deg on every axis. One line of JSON a condition.
#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/bench/stereo/rendered_pair.hpp"
#include "tests/bench/stereo/score.hpp"
#include "vision/refine/pose_refiner.hpp"
#include "vision/refine/so3.hpp"
#include "vision/stereo/pair_matcher.hpp"

namespace kawara::vision {
namespace {

using namespace stereo_bench;  // NOLINT(google-build-using-namespace): a program's own parts

constexpr int kSize = 1024;
constexpr int kFrames = 25;
constexpr double kStep = 0.25;
constexpr double kPositionSd = 0.02;
constexpr double kAttitudeSd = 0.1 * core::kRadFromDeg;
/// A pair's first frame is this many before the newest when it is matched.
constexpr std::size_t kLag = 8;
constexpr std::size_t kPairStep = 2;

struct Drive {
  std::shared_ptr<const CameraModel> model;
  std::shared_ptr<const StereoCamera> camera;
  std::vector<Eigen::Isometry3d> truth, measured;
  std::vector<StereoLab::Frame> frames;
};

Drive RenderDrive(std::uint32_t seed) {
  Drive drive;
  drive.model = std::make_shared<DoughnutCamera>(
      *DoughnutCamera::Create(DoughnutParameters{}.Resized(kSize, kSize)));
  drive.camera = std::make_shared<StereoCamera>(drive.model);
  test_support::StereoLabOptions options;
  options.seed = seed;
  const StereoLab lab(options);
  std::mt19937 dice(seed);
  std::normal_distribution<double> normal;
  const auto normals = [&](double sd) {
    return Eigen::Vector3d(sd * normal(dice), sd * normal(dice), sd * normal(dice));
  };
  for (int i = 0; i < kFrames; ++i) {
    const Eigen::Isometry3d pose = Pose(kStep * (i - kFrames / 2), dice);
    drive.truth.push_back(pose);
    Eigen::Isometry3d measured = pose;
    measured.translation() += normals(kPositionSd);
    measured.linear() = pose.linear() * Exp(normals(kAttitudeSd));
    drive.measured.push_back(measured);
  }
  drive.frames.resize(kFrames);
  const auto render = [&](std::size_t first) {
    for (std::size_t i = first; i < drive.frames.size(); i += 2) {
      drive.frames[i] =
          lab.Render(*drive.model, drive.truth[i], 1000 * seed + static_cast<std::uint32_t>(i));
    }
  };
  std::thread other(render, 1);
  render(0);
  other.join();
  return drive;
}

struct Steps {
  double turn = 0, length = 0, position = 0, attitude = 0, count = 0;
  void Add(const Drive& drive, std::size_t a, std::size_t b, const Eigen::Isometry3d& pose_a,
           const Eigen::Isometry3d& pose_b) {
    const Eigen::Isometry3d step = pose_a.inverse() * pose_b;
    const Eigen::Isometry3d truth = drive.truth[a].inverse() * drive.truth[b];
    turn += Log(truth.linear().transpose() * step.linear()).squaredNorm();
    const double ratio = step.translation().norm() / truth.translation().norm() - 1.0;
    length += ratio * ratio;
    position += (pose_a.translation() - drive.truth[a].translation()).squaredNorm() / 3.0;
    attitude += Log(drive.truth[a].linear().transpose() * pose_a.linear()).squaredNorm() / 3.0;
    count += 1;
  }
  void Print(const char* condition, double cpu_s_frame) const {
    std::printf(
        "{\"condition\": \"%s\", \"method\": \"poses\", \"turn_deg\": %.4f, \"length_percent\": "
        "%.3f, \"position_mm\": %.2f, \"attitude_deg\": %.4f, \"cpu_ms_frame\": %.1f}\n",
        condition, std::sqrt(turn / count) / core::kRadFromDeg, 100.0 * std::sqrt(length / count),
        1e3 * std::sqrt(position / count), std::sqrt(attitude / count) / core::kRadFromDeg,
        1e3 * cpu_s_frame);
  }
};

Pair PairOf(const Drive& drive, std::size_t a, std::size_t b) {
  return {drive.model,     drive.camera,   drive.frames[a],
          drive.frames[b], drive.truth[a], drive.truth[b]};
}

void Match(const Drive& drive, std::size_t a, std::size_t b, const Eigen::Isometry3d& pose_a,
           const Eigen::Isometry3d& pose_b, const StepDoubt& doubt, Score& score) {
  PairMatcher matcher({});
  RangeImage ranges;
  const StereoView view_a{drive.camera.get(), drive.frames[a].view(), pose_a};
  const StereoView view_b{drive.camera.get(), drive.frames[b].view(), pose_b};
  if (!matcher.Match(view_a, view_b, ranges, doubt)) std::abort();
  score.Add(PairOf(drive, a, b), ranges, 0.0);
}

int Main(std::uint32_t seeds) {
  const StepDoubt raw_doubt{std::sqrt(2.0) * kPositionSd / kBaseline, std::sqrt(2.0) * kAttitudeSd};
  Score raw_score, refined_score, true_score;
  Steps raw, refined;
  double cpu_s = 0.0, frames = 0.0;
  for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
    const Drive drive = RenderDrive(seed);
    PoseRefiner refiner({}, {{drive.camera.get(), Eigen::Isometry3d::Identity()}});
    for (std::size_t i = 0; i < drive.frames.size(); ++i) {
      PriorPose prior;
      prior.map_from_body = drive.measured[i];
      const RigPicture picture{0, drive.frames[i].view()};
      const double start = CpuSeconds();
      if (!refiner.Add(prior, std::span(&picture, 1))) std::abort();
      cpu_s += CpuSeconds() - start;
      frames += 1.0;
      if (i < 14) continue;
      const std::size_t a = i - kLag, b = a + kPairStep;
      raw.Add(drive, a, b, drive.measured[a], drive.measured[b]);
      refined.Add(drive, a, b, refiner.pose(a), refiner.pose(b));
      if (i % 3 != 0) continue;
      Match(drive, a, b, drive.truth[a], drive.truth[b], {}, true_score);
      Match(drive, a, b, drive.measured[a], drive.measured[b], raw_doubt, raw_score);
      Match(drive, a, b, refiner.pose(a), refiner.pose(b), refiner.Doubt(a, b), refined_score);
    }
    std::fprintf(stderr, "seed %u: %.3f px, %.0f sightings a frame, mounting %.3f %.3f %.3f deg\n",
                 seed, refiner.ray_sd_px(), refiner.sightings_per_frame(),
                 refiner.rig().mounting_rad.x() / core::kRadFromDeg,
                 refiner.rig().mounting_rad.y() / core::kRadFromDeg,
                 refiner.rig().mounting_rad.z() / core::kRadFromDeg);
  }
  raw.Print("poses: 2 cm, 0.1 deg", 0.0);
  refined.Print("poses refined on pictures", cpu_s / frames);
  true_score.Print("drive, true poses", "kawara fast");
  raw_score.Print("drive, poses 2 cm, 0.1 deg", "kawara fast");
  refined_score.Print("drive, refined poses", "kawara fast");
  return 0;
}

}  // namespace
}  // namespace kawara::vision

int main(int count, char** words) {
  return kawara::vision::Main(count > 1 ? static_cast<std::uint32_t>(std::atoi(words[1])) : 3);
}
