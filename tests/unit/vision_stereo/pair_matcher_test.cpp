#include "vision/stereo/pair_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/stereo_lab.hpp"
#include "vision/camera/camera_choice.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::vision {
namespace {

using test_support::StereoLab;

/// The standard doughnut at a quarter of its size: fast, and coarse enough for all goals to be far.
std::shared_ptr<const CameraModel> SmallDoughnut() {
  const auto small = DoughnutParameters{}.Resized(384, 384);
  return std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(small));
}

Eigen::Isometry3d Pose(double along_m, double turn_rad) {
  Eigen::Matrix3d map_from_frd;
  map_from_frd << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(along_m, 0.0, 2.0);
  pose.linear() = map_from_frd *
                  Eigen::AngleAxisd(turn_rad, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()) *
                  BodyFromCamera();
  return pose;
}

struct Errors {
  double rms_m = 0.0;        ///< of those within 10 %
  double outliers = 0.0;     ///< part of the estimates
  double known = 0.0;        ///< part of the pixels between 2 and 6 m, 25 deg from the baseline
  double within_2_sd = 0.0;  ///< part of the estimates
};

Errors Judge(const RangeImage& ranges, const StereoLab::Frame& truth, const CameraModel& camera,
             const Eigen::Vector3d& baseline_camera) {
  Errors errors;
  double sum = 0.0, near = 0.0, wanted = 0.0, known = 0.0, honest = 0.0;
  for (int v = 0; v < ranges.height_px; ++v) {
    for (int u = 0; u < ranges.width_px; ++u) {
      const std::size_t i = ranges.index(u, v);
      const double range = static_cast<double>(truth.range_m[i]);
      if (!(range >= 2.0 && range <= 6.0)) continue;
      const auto ray = camera.Unproject({u, v});
      if (std::abs(ray->dot(baseline_camera)) > std::cos(25.0 * core::kRadFromDeg)) continue;
      wanted += 1.0;
      if (std::isnan(ranges.range_m[i])) continue;
      known += 1.0;
      const double error = static_cast<double>(ranges.range_m[i]) - range;
      if (std::abs(error) < 2.0 * static_cast<double>(ranges.sd_m[i])) honest += 1.0;
      if (std::abs(error) > 0.1 * range) continue;
      near += 1.0;
      sum += error * error;
    }
  }
  errors.rms_m = std::sqrt(sum / near);
  errors.outliers = 1.0 - near / known;
  errors.known = known / wanted;
  errors.within_2_sd = honest / known;
  return errors;
}

struct Pair {
  StereoLab::Frame a, b;
  Eigen::Isometry3d pose_a, pose_b;
  Eigen::Vector3d baseline_camera() const {
    return pose_a.linear().transpose() * (pose_b.translation() - pose_a.translation()).normalized();
  }
};

Pair LabPair(const CameraModel& camera_a, const CameraModel& camera_b) {
  test_support::StereoLabOptions options;
  options.samples = 2;
  const StereoLab lab(options);
  Pair pair{{}, {}, Pose(-0.25, 0.02), Pose(0.25, -0.03)};
  pair.a = lab.Render(camera_a, pair.pose_a, 1);
  pair.b = lab.Render(camera_b, pair.pose_b, 2);
  return pair;
}

class PairMatcherTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    model_ = SmallDoughnut();
    camera_ = new StereoCamera(model_);
    pair_ = new Pair(LabPair(*model_, *model_));
  }
  static void TearDownTestSuite() {
    delete pair_;
    delete camera_;
    model_.reset();
  }

  static RangeImage Match(const StereoLab::Frame& a, const StereoLab::Frame& b) {
    PairMatcher matcher({});
    RangeImage ranges;
    const auto done = matcher.Match({camera_, a.view(), pair_->pose_a},
                                    {camera_, b.view(), pair_->pose_b}, ranges);
    EXPECT_TRUE(done);
    return ranges;
  }
  static Errors Judged(const RangeImage& ranges) {
    return Judge(ranges, pair_->a, *model_, pair_->baseline_camera());
  }

  static inline std::shared_ptr<const CameraModel> model_;
  static inline StereoCamera* camera_ = nullptr;
  static inline Pair* pair_ = nullptr;
};

// A third of the standard resolution: a quarter pixel is 37 mm rms between 2 and 6 m at full size.
TEST_F(PairMatcherTest, RangesOfASceneAreRightAndSoAreTheirDeviations) {
  const Errors errors = Judged(Match(pair_->a, pair_->b));
  EXPECT_LT(errors.rms_m, 0.060);
  EXPECT_LT(errors.outliers, 0.01);
  EXPECT_GT(errors.known, 0.90);
  EXPECT_GT(errors.within_2_sd, 0.88);  // nearly every pixel is near an edge at this size
}

TEST_F(PairMatcherTest, AThirdLessExposureDoesNotMatter) {
  const Errors as_it_was = Judged(Match(pair_->a, pair_->b));
  StereoLab::Frame darker = pair_->b;
  for (auto& level : darker.rgb) level = static_cast<std::uint8_t>(0.7 * level + 0.5);
  const Errors errors = Judged(Match(pair_->a, darker));
  EXPECT_LT(errors.rms_m, 1.15 * as_it_was.rms_m);
  EXPECT_LT(errors.outliers, 0.01);
  EXPECT_GT(errors.known, as_it_was.known - 0.02);
}

TEST_F(PairMatcherTest, TheRobotsOwnBodyIsNotMeasured) {
  std::vector<std::uint8_t> mask(pair_->a.range_m.size(), 255);
  for (int v = 150; v < 200; ++v) {
    for (int u = 20; u < 60; ++u) mask[static_cast<std::size_t>(384 * v + u)] = 0;
  }
  const StereoCamera masked(model_, mask);
  PairMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match({&masked, pair_->a.view(), pair_->pose_a},
                            {&masked, pair_->b.view(), pair_->pose_b}, ranges));
  for (int v = 150; v < 200; ++v) {
    for (int u = 20; u < 60; ++u) EXPECT_TRUE(std::isnan(ranges.range_m[ranges.index(u, v)]));
  }
}

TEST_F(PairMatcherTest, TheSameTwiceIsTheSameBytes) {
  PairMatcher matcher({});
  RangeImage first, second;
  ASSERT_TRUE(matcher.Match({camera_, pair_->a.view(), pair_->pose_a},
                            {camera_, pair_->b.view(), pair_->pose_b}, first));
  ASSERT_TRUE(matcher.Match({camera_, pair_->b.view(), pair_->pose_b},
                            {camera_, pair_->a.view(), pair_->pose_a}, second));
  ASSERT_TRUE(matcher.Match({camera_, pair_->a.view(), pair_->pose_a},
                            {camera_, pair_->b.view(), pair_->pose_b}, second));
  EXPECT_EQ(std::memcmp(first.range_m.data(), second.range_m.data(), 4 * first.range_m.size()), 0);
  EXPECT_EQ(std::memcmp(first.sd_m.data(), second.sd_m.data(), 4 * first.sd_m.size()), 0);
}

TEST_F(PairMatcherTest, NoBaselineIsAnError) {
  PairMatcher matcher({});
  RangeImage ranges;
  EXPECT_FALSE(matcher.Match({camera_, pair_->a.view(), pair_->pose_a},
                             {camera_, pair_->b.view(), pair_->pose_a}, ranges));
}

// A camera without a radial table, against a doughnut: any two models make a pair.
TEST(PairMatcher, TwoDifferentCamerasMakeAPair) {
  const auto ring = SmallDoughnut();
  const auto sphere = std::make_shared<EquirectangularCamera>(
      *EquirectangularCamera::Create(EquirectangularParameters{640, 320}.Geometry()));
  const Pair pair = LabPair(*ring, *sphere);
  const StereoCamera a(ring), b(sphere);
  PairMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(
      matcher.Match({&a, pair.a.view(), pair.pose_a}, {&b, pair.b.view(), pair.pose_b}, ranges));
  const Errors errors = Judge(ranges, pair.a, *ring, pair.baseline_camera());
  EXPECT_LT(errors.rms_m, 0.075);
  EXPECT_LT(errors.outliers, 0.02);
  EXPECT_GT(errors.known, 0.85);
}

}  // namespace
}  // namespace kawara::vision
