// bench_stereo_pairs SEEDS: distance images of rendered pairs by this project and by OpenCV's
// StereoSGBM and StereoBM on the same rectified pictures, judged against the rendered ranges. One
// line of JSON a method and condition. The judge: pixels whose true range is 2 to 6 m, 25 deg or
// more from the baseline, seen by both cameras; std of the errors within 10 % of the range, NMAD of
// all, outliers beyond 10 %, density.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/stereo/rendered_pair.hpp"
#include "tests/bench/stereo/score.hpp"
#include "vision/stereo/pair_matcher.hpp"
#include "vision/stereo/paper_matcher.hpp"
#include "vision/stereo/range_kernel.hpp"

namespace kawara::vision {
namespace {

using namespace stereo_bench;  // NOLINT(google-build-using-namespace): a program's own parts

/// OpenCV's matchers want the nearer thing further left in the second picture: both are mirrored.
cv::Mat ForOpenCv(const RectifiedPicture& picture, bool colour) {
  cv::Mat rgb(picture.grid.height_px, picture.grid.width_px, CV_8UC3);
  for (int y = 0; y < rgb.rows; ++y) {
    for (int x = 0; x < rgb.cols; ++x) {
      const std::uint32_t word = picture.row(y)[rgb.cols - 1 - x];
      rgb.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(word >> 16),
                                 static_cast<std::uint8_t>(word >> 8),
                                 static_cast<std::uint8_t>(word)};
    }
  }
  if (colour) return rgb;
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

/// Disparities of a matcher of OpenCV as a distance image, by the same triangulation as ours.
RangeImage RangesOf(const cv::Mat& disparity_16, const Pair& pair, const EpipolarGrid& grid) {
  std::vector<float> disparity(grid.pixels()), sd(grid.pixels(), 0.1F);
  for (int y = 0; y < grid.height_px; ++y) {
    for (int x = 0; x < grid.width_px; ++x) {
      const int value = disparity_16.at<short>(y, grid.width_px - 1 - x);
      disparity[static_cast<std::size_t>(y * grid.width_px + x)] =
          value > 0 ? static_cast<float>(value) / 16.0F : -1e4F;
    }
  }
  const EpipolarPair geometry = *EpipolarPair::FromPoses(pair.pose_a, pair.pose_b);
  range::FieldView view;
  view.disparity_px = disparity.data();
  view.sd_px = sd.data();
  view.width = grid.width_px;
  view.height = grid.height_px;
  view.px_per_rad = static_cast<float>(grid.px_per_rad);
  view.first_alpha_rad = static_cast<float>(grid.first_alpha_rad);
  view.baseline_m = static_cast<float>(geometry.baseline_m);
  for (int i = 0; i < 9; ++i) {
    view.epipolar_from_camera[i] = static_cast<float>(geometry.a_from_epipolar(i % 3, i / 3));
  }
  RangeImage ranges;
  const MaskedRays& rays = pair.camera->rays();
  ranges.Reset(rays.width_px(), rays.height_px());
  const std::size_t pixels = ranges.range_m.size();
  ranges.range_m.resize(pixels + 16);
  ranges.sd_m.resize(pixels + 16);
  range::RangesOfRow(view, rays.x(), rays.y(), rays.z(), pixels, ranges.range_m.data(),
                     ranges.sd_m.data());
  return ranges;
}

struct Peer {
  const char* name;
  bool colour;
  std::function<cv::Ptr<cv::StereoMatcher>(int disparities)> make;
};

/// The settings are those of OpenCV's own stereo sample, blocks of 5, uniqueness 10 %.
cv::Ptr<cv::StereoMatcher> Sgbm(int disparities, int channels, int mode) {
  const int block = 5;
  return cv::StereoSGBM::create(0, disparities, block, 8 * channels * block * block,
                                32 * channels * block * block, 1, 63, 10, 100, 2, mode);
}

cv::Ptr<cv::StereoMatcher> Bm(int disparities) {
  auto matcher = cv::StereoBM::create(disparities, 15);
  matcher->setUniquenessRatio(15);
  matcher->setSpeckleWindowSize(100);
  matcher->setSpeckleRange(2);
  return matcher;
}

/// Density is of the candidates: the paper's method measures colour edges only.
void JudgePaper(const std::string& condition, const std::vector<Pair>& pairs) {
  PaperMatcher matcher({});
  Score score;
  score.judged = [&](std::size_t pixel) { return matcher.candidate(pixel); };
  for (const Pair& pair : pairs) {
    RangeImage ranges;
    const double start = CpuSeconds();
    if (!matcher.Match(pair.view_a(), pair.view_b(), ranges)) std::abort();
    score.Add(pair, ranges, CpuSeconds() - start);
  }
  score.Print(condition, "kawara paper");
}

void Judge(const std::string& condition, const std::vector<Pair>& pairs, bool with_peers) {
  PairMatcher matcher({});
  Score ours;
  for (const Pair& pair : pairs) {
    RangeImage ranges;
    double best_s = 1e9;
    for (int run = 0; run < 3; ++run) {
      const double start = CpuSeconds();
      if (!matcher.Match(pair.view_a(), pair.view_b(), ranges)) std::abort();
      best_s = std::min(best_s, CpuSeconds() - start);
    }
    ours.Add(pair, ranges, best_s);
  }
  ours.Print(condition, "kawara fast");
  if (!with_peers) return;
  JudgePaper(condition, pairs);
  const Peer peers[] = {
      {"StereoSGBM colour", true, [](int d) { return Sgbm(d, 3, cv::StereoSGBM::MODE_SGBM); }},
      {"StereoSGBM 3-way grey", false,
       [](int d) { return Sgbm(d, 1, cv::StereoSGBM::MODE_SGBM_3WAY); }},
      {"StereoBM grey", false, Bm},
  };
  for (const Peer& peer : peers) {
    Score score;
    for (const Pair& pair : pairs) {
      // Rectification is ours and counts for all.
      const double start = CpuSeconds();
      Rectifier rectifier;
      RectifiedPicture a, b;
      const EpipolarPair geometry = *EpipolarPair::FromPoses(pair.pose_a, pair.pose_b);
      const EpipolarGrid grid =
          EpipolarGrid::Make(pair.camera->mean_px_per_rad(), 10 * core::kRadFromDeg);
      rectifier.Rectify(*pair.camera, pair.a.view(), geometry.a_from_epipolar, grid, a);
      rectifier.Rectify(*pair.camera, pair.b.view(), geometry.b_from_epipolar, grid, b);
      const int disparities =
          static_cast<int>(1.05 * std::atan2(kBaseline, 1.5) * grid.px_per_rad + 15) / 16 * 16;
      cv::Mat disparity;
      peer.make(disparities)
          ->compute(ForOpenCv(a, peer.colour), ForOpenCv(b, peer.colour), disparity);
      const RangeImage ranges = RangesOf(disparity, pair, grid);
      score.Add(pair, ranges, CpuSeconds() - start);
    }
    score.Print(condition, peer.name);
  }
}

/// Pairs a second of two threads, each with a matcher of its own.
void Throughput(const std::string& condition, const Pair& pair) {
  constexpr int kRuns = 8;
  const auto work = [&pair] {
    PairMatcher matcher({});
    RangeImage ranges;
    for (int i = 0; i < kRuns; ++i) {
      if (!matcher.Match(pair.view_a(), pair.view_b(), ranges)) std::abort();
    }
  };
  work();
  const auto start = std::chrono::steady_clock::now();
  std::thread other(work);
  work();
  other.join();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("{\"condition\": \"%s\", \"method\": \"throughput\", \"pairs_per_s\": %.2f}\n",
              condition.c_str(), 2 * kRuns / seconds);
}

int Main(int seeds) {
  cv::setNumThreads(1);
  const auto render = [&](int size_px, double contrast, double exposure, int count) {
    std::vector<Pair> pairs;
    for (int seed = 1; seed <= count; ++seed) {
      pairs.push_back(RenderPair(static_cast<std::uint32_t>(seed), size_px, contrast, exposure));
    }
    return pairs;
  };
  {
    const auto pairs = render(1024, 1.0, 1.0, seeds);
    Judge("1024", pairs, true);
    Throughput("1024", pairs.front());
  }
  Judge("1024, exposure -30 %", render(1024, 1.0, 0.7, 1), true);
  Judge("1024, paint x 0.1", render(1024, 0.1, 1.0, std::min(seeds, 2)), true);
  {
    const auto pairs = render(2048, 1.0, 1.0, 1);
    Judge("2048", pairs, true);
    Throughput("2048", pairs.front());
  }
  return 0;
}

}  // namespace
}  // namespace kawara::vision

int main(int count, char** words) {
  return kawara::vision::Main(count > 1 ? std::atoi(words[1]) : 3);
}
