// bench_stereo_model survey DIR SEED FRAMES: a drive of rendered pictures a quarter of a metre
// apart as a survey folder; poses with white noise of 2 cm and 0.1 deg on every axis.
// bench_stereo_model judge SEED FRAMES < POINTS (x y z as doubles): how far a model's points within
// 6 m of that drive are from the street's surfaces, and how much of what its cameras saw at 2 to
// 5.5 m has a point within 15 cm. One line of JSON.
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "tests/bench/stereo/rendered_pair.hpp"
#include "vision/jpeg.hpp"
#include "vision/refine/so3.hpp"

namespace kawara::vision {
namespace {

using namespace stereo_bench;  // NOLINT(google-build-using-namespace): a program's own parts

constexpr int kSize = 1024;
constexpr double kStep = 0.25;
constexpr double kPositionSd = 0.02, kAttitudeSdDeg = 0.1;
constexpr double kJudged = 6.0, kComplete = 0.15;

StereoLab LabOf(std::uint32_t seed) {
  test_support::StereoLabOptions options;
  options.seed = seed;
  return StereoLab(options);
}

std::vector<Eigen::Isometry3d> Drive(std::uint32_t seed, int frames) {
  std::mt19937 dice(seed);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < frames; ++i) poses.push_back(Pose(kStep * (i - frames / 2), dice));
  return poses;
}

DoughnutCamera Camera() {
  return *DoughnutCamera::Create(DoughnutParameters{}.Resized(kSize, kSize));
}

void WritePoses(const std::filesystem::path& folder, const std::vector<Eigen::Isometry3d>& truth,
                std::uint32_t seed) {
  std::mt19937 dice(seed + 1000);
  std::normal_distribution<double> normal;
  const auto normals = [&](double sd) {
    return Eigen::Vector3d(sd * normal(dice), sd * normal(dice), sd * normal(dice));
  };
  std::ofstream table(folder / "poses.csv");
  table.precision(12);
  table << "frame,x,y,z,qw,qx,qy,qz,sd_position_m,sd_attitude_deg\n";
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d place = truth[i].translation() + normals(kPositionSd);
    const Eigen::Matrix3d R = truth[i].linear() * Exp(normals(kAttitudeSdDeg * core::kRadFromDeg)) *
                              Eigen::Matrix3d(BodyFromCamera()).transpose();
    const Eigen::Quaterniond q(R);
    table << i << ',' << place.x() << ',' << place.y() << ',' << place.z() << ',' << q.w() << ','
          << q.x() << ',' << q.y() << ',' << q.z() << ',' << kPositionSd << ',' << kAttitudeSdDeg
          << '\n';
  }
  const DoughnutParameters ring = DoughnutParameters{}.Resized(kSize, kSize);
  std::ofstream camera(folder / "camera.yaml");
  camera << "camera: doughnut\ndoughnut:\n  width_px: " << kSize << "\n  height_px: " << kSize
         << "\n  center_u_px: " << ring.center_u_px << "\n  center_v_px: " << ring.center_v_px
         << "\n  l_in_px: " << ring.l_in_px << "\n  l_base_px: " << ring.l_base_px
         << "\n  l_out_px: " << ring.l_out_px << "\n  phi_top_deg: " << ring.phi_top_deg
         << "\n  phi_bottom_deg: " << ring.phi_bottom_deg << "\n";
}

int WriteSurvey(const std::filesystem::path& folder, std::uint32_t seed, int frames) {
  std::filesystem::create_directories(folder / "frames");
  const auto poses = Drive(seed, frames);
  WritePoses(folder, poses, seed);
  const StereoLab lab = LabOf(seed);
  const auto render = [&](std::size_t first) {
    const DoughnutCamera camera = Camera();
    JpegEncoder encoder;
    for (std::size_t i = first; i < poses.size(); i += 2) {
      const auto frame = lab.Render(camera, poses[i], 1000 * seed + static_cast<std::uint32_t>(i));
      const auto jpeg = encoder.Encode(frame.view(), {.quality = 95});
      if (!jpeg) std::abort();
      std::ofstream file(folder / "frames" / (std::to_string(i) + ".jpg"), std::ios::binary);
      file.write(reinterpret_cast<const char*>(jpeg->data()),
                 static_cast<std::streamsize>(jpeg->size()));
    }
  };
  std::thread other(render, 1);
  render(0);
  other.join();
  return 0;
}

/// Points by cells of the size they are looked for within.
class PointCells {
 public:
  void Add(const Eigen::Vector3d& point) { cells_[CellOf(point)].push_back(point); }
  bool AnyNear(const Eigen::Vector3d& place) const {
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3d step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const auto cell = cells_.find(CellOf(place + kComplete * step));
      if (cell == cells_.end()) continue;
      for (const Eigen::Vector3d& point : cell->second) {
        if ((point - place).norm() < kComplete) return true;
      }
    }
    return false;
  }

 private:
  static std::int64_t CellOf(const Eigen::Vector3d& point) {
    std::int64_t cell = 0;
    for (int k = 0; k < 3; ++k) {
      cell = cell * 1'000'003 + std::llround(std::floor(point[k] / kComplete));
    }
    return cell;
  }
  std::unordered_map<std::int64_t, std::vector<Eigen::Vector3d>> cells_;
};

int Judge(std::uint32_t seed, int frames) {
  const StereoLab lab = LabOf(seed);
  const auto poses = Drive(seed, frames);
  PointCells cells;
  double points = 0, square = 0, far = 0;
  std::array<double, 3> xyz{};
  while (std::fread(xyz.data(), sizeof(double), xyz.size(), stdin) == xyz.size()) {
    const Eigen::Vector3d point(xyz[0], xyz[1], xyz[2]);
    cells.Add(point);
    double off_path = 1e9;
    for (const auto& pose : poses) {
      off_path = std::min(off_path, (pose.translation() - point).norm());
    }
    if (off_path > kJudged) continue;
    const double distance = lab.DistanceToSurface(point);
    points += 1;
    square += distance * distance;
    far += distance > 0.3 ? 1 : 0;
  }
  const DoughnutCamera camera = Camera();
  double seen = 0, found = 0;
  for (std::size_t i = 0; i < poses.size(); i += 2) {
    for (int v = 0; v < kSize; v += 8) {
      for (int u = 0; u < kSize; u += 8) {
        const auto ray = camera.Unproject({u, v});
        if (!ray) continue;
        const Eigen::Vector3d along = poses[i].linear() * *ray;
        const auto hit = lab.Cast(poses[i].translation(), along);
        if (!(hit.range_m > 2.0 && hit.range_m < 5.5)) continue;
        seen += 1;
        found += cells.AnyNear(poses[i].translation() + hit.range_m * along) ? 1 : 0;
      }
    }
  }
  std::printf(
      "{\"points\": %.0f, \"rms_mm\": %.2f, \"over_300_mm\": %.3f, \"completeness\": %.2f}\n",
      points, 1e3 * std::sqrt(square / std::max(1.0, points)), 100.0 * far / std::max(1.0, points),
      100.0 * found / seen);
  return points > 0 ? 0 : 1;
}

int Main(const std::vector<std::string>& words) {
  const auto number = [&](std::size_t i) { return std::atoi(words.at(i).c_str()); };
  if (words.size() == 4 && words[0] == "survey") {
    return WriteSurvey(words[1], static_cast<std::uint32_t>(number(2)), number(3));
  }
  if (words.size() == 3 && words[0] == "judge") {
    return Judge(static_cast<std::uint32_t>(number(1)), number(2));
  }
  std::fprintf(stderr,
               "bench_stereo_model: expected survey DIR SEED FRAMES, or judge SEED FRAMES\n");
  return 2;
}

}  // namespace
}  // namespace kawara::vision

int main(int count, char** words) { return kawara::vision::Main({words + 1, words + count}); }
