// bench_stereo_several SEEDS: distance images made with several other pictures, judged as those of
// pairs are (score.hpp). One line of JSON a condition; CPU of one thread, for one distance image.
#include <cstdio>
#include <cstdlib>
#include <span>
#include <thread>
#include <vector>

#include "tests/bench/stereo/rendered_pair.hpp"
#include "tests/bench/stereo/score.hpp"
#include "vision/stereo/multi_matcher.hpp"

namespace kawara::vision {
namespace {

using namespace stereo_bench;  // NOLINT(google-build-using-namespace): a program's own parts

constexpr int kSize = 1024;
/// Where the pictures were taken, along the street [m]; the first is the one that is measured.
constexpr double kAlong[] = {0.0, 0.5, -0.5, 0.25, -0.25, 0.75, -0.75, 1.0, -1.0};
constexpr std::size_t kPair = 1, kFour = 4, kAll = 8;

struct Series {
  std::shared_ptr<const CameraModel> model;
  std::shared_ptr<const StereoCamera> camera;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<StereoLab::Frame> frames;

  StereoView view(std::size_t i) const { return {camera.get(), frames[i].view(), poses[i]}; }
};

Series RenderSeries(std::uint32_t seed, double vehicle_contrast, std::size_t others) {
  Series series;
  series.model = std::make_shared<DoughnutCamera>(
      *DoughnutCamera::Create(DoughnutParameters{}.Resized(kSize, kSize)));
  series.camera = std::make_shared<StereoCamera>(series.model);
  test_support::StereoLabOptions options;
  options.seed = seed;
  options.vehicle_contrast = vehicle_contrast;
  const StereoLab lab(options);
  std::mt19937 dice(seed);
  for (std::size_t i = 0; i <= others; ++i) series.poses.push_back(Pose(kAlong[i], dice));
  series.frames.resize(others + 1);
  const auto render = [&](std::size_t first) {
    for (std::size_t i = first; i < series.frames.size(); i += 2) {
      series.frames[i] =
          lab.Render(*series.model, series.poses[i], 1000 * seed + static_cast<std::uint32_t>(i));
    }
  };
  std::thread other(render, 1);
  render(0);
  other.join();
  return series;
}

/// Of the series' first picture with those after it, in the least time of two runs.
void Judge(const Series& series, std::size_t others, Score& score) {
  std::vector<StereoView> views;
  std::vector<Taken> taken;
  for (std::size_t i = 1; i <= others; ++i) {
    views.push_back(series.view(i));
    taken.push_back({&series.frames[i], series.poses[i]});
  }
  MultiMatcher matcher({});
  RangeImage ranges;
  double best_s = 1e9;
  for (int run = 0; run < 2; ++run) {
    const double start = CpuSeconds();
    if (!matcher.Match(series.view(0), views, ranges)) std::abort();
    best_s = std::min(best_s, CpuSeconds() - start);
  }
  score.Add(*series.model, {&series.frames[0], series.poses[0]}, taken, ranges, best_s);
}

int Main(std::uint32_t seeds) {
  Score pair, four, all, paint;
  for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
    const bool with_all = seed == 1;
    const Series series = RenderSeries(seed, 1.0, with_all ? kAll : kFour);
    Judge(series, kPair, pair);
    Judge(series, kFour, four);
    if (with_all) Judge(series, kAll, all);
  }
  Judge(RenderSeries(1, 0.1, kFour), kFour, paint);
  pair.Print("1024, one of the baselines", "kawara fast");
  four.Print("1024, several baselines", "kawara fast");
  all.Print("1024, eight baselines up to 1 m", "kawara fast");
  paint.Print("1024, several baselines, paint x 0.1", "kawara fast");
  return 0;
}

}  // namespace
}  // namespace kawara::vision

int main(int count, char** words) {
  return kawara::vision::Main(count > 1 ? static_cast<std::uint32_t>(std::atoi(words[1])) : 3);
}
