#include "vision/stereo/multi_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "tests/support/stereo_lab.hpp"
#include "vision/camera/doughnut_camera.hpp"

// With two std::threads in one of the tests.
namespace kawara::vision {
namespace {

using test_support::StereoLab;

constexpr int kSize = 320;
constexpr double kAlong[] = {0.0, 0.5, -0.5, 0.25, -0.25};

Eigen::Isometry3d Pose(double along_m) {
  Eigen::Matrix3d map_from_frd;
  map_from_frd << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(along_m, 0.02 * along_m, 2.0);
  pose.linear() = map_from_frd *
                  Eigen::AngleAxisd(0.05 * along_m, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()) *
                  BodyFromCamera();
  return pose;
}

/// A small picture of the lab's street, with four others of it; the truck's paint is poor.
class MultiMatcherTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    model_ = std::make_shared<DoughnutCamera>(
        *DoughnutCamera::Create(DoughnutParameters{}.Resized(kSize, kSize)));
    camera_ = std::make_shared<StereoCamera>(model_);
    test_support::StereoLabOptions options;
    options.samples = 2;
    options.vehicle_contrast = 0.3;
    const StereoLab lab(options);
    std::uint32_t noise = 1;
    for (const double along : kAlong) frames_.push_back(lab.Render(*model_, Pose(along), noise++));
  }
  static void TearDownTestSuite() {
    frames_.clear();
    camera_.reset();
    model_.reset();
  }

  static StereoView View(std::size_t i) {
    return {camera_.get(), frames_[i].view(), Pose(kAlong[i])};
  }
  static std::vector<StereoView> Others(std::size_t count) {
    std::vector<StereoView> others;
    for (std::size_t i = 1; i <= count; ++i) others.push_back(View(i));
    return others;
  }
  static RangeImage Match(std::size_t count, int threads = 1) {
    MultiMatcherOptions options;
    options.threads = threads;
    MultiMatcher matcher(options);
    RangeImage ranges;
    EXPECT_TRUE(matcher.Match(View(0), Others(count), ranges));
    return ranges;
  }

  struct Quality {
    double known = 0, outliers = 0, square = 0, within_2_sd = 0;
    double rms_m() const { return std::sqrt(square / (known - outliers)); }
  };
  /// Of pixels between 2 and 6 m, wherever they look, so the poles too.
  static Quality Judged(const RangeImage& ranges) {
    Quality quality;
    for (std::size_t i = 0; i < ranges.range_m.size(); ++i) {
      const double truth = static_cast<double>(frames_[0].range_m[i]);
      if (!(truth >= 2.0 && truth <= 6.0) || std::isnan(ranges.range_m[i])) continue;
      const double error = static_cast<double>(ranges.range_m[i]) - truth;
      quality.known += 1;
      if (std::abs(error) < 2.0 * static_cast<double>(ranges.sd_m[i])) quality.within_2_sd += 1;
      if (std::abs(error) > 0.1 * truth) {
        quality.outliers += 1;
      } else {
        quality.square += error * error;
      }
    }
    return quality;
  }

  static inline std::shared_ptr<const CameraModel> model_;
  static inline std::shared_ptr<const StereoCamera> camera_;
  static inline std::vector<StereoLab::Frame> frames_;
};

void ExpectSame(const RangeImage& a, const RangeImage& b) {
  ASSERT_EQ(a.range_m.size(), b.range_m.size());
  const std::size_t bytes = a.range_m.size() * sizeof(float);
  EXPECT_EQ(std::memcmp(a.range_m.data(), b.range_m.data(), bytes), 0);
  EXPECT_EQ(std::memcmp(a.sd_m.data(), b.sd_m.data(), bytes), 0);
}

TEST_F(MultiMatcherTest, FourOthersSeeMoreAndErrLessThanOne) {
  const Quality one = Judged(Match(1)), four = Judged(Match(4));
  EXPECT_GT(four.known, 1.01 * one.known);
  EXPECT_LT(four.outliers, 0.8 * one.outliers);
  EXPECT_LT(four.rms_m(), 0.9 * one.rms_m());
  EXPECT_GT(four.within_2_sd / four.known, one.within_2_sd / one.known - 0.02);
}

TEST_F(MultiMatcherTest, OneOtherIsAPair) {
  PairMatcher pair({});
  RangeImage ranges;
  ASSERT_TRUE(pair.Match(View(0), View(1), ranges));
  ExpectSame(Match(1), ranges);
}

TEST_F(MultiMatcherTest, TwoThreadsMakeTheSameBytes) { ExpectSame(Match(4, 2), Match(4, 1)); }

TEST_F(MultiMatcherTest, DoubtIsInTheDeviations) {
  MultiMatcher matcher({});
  RangeImage sure, unsure;
  const auto others = Others(2);
  const std::vector<StepDoubt> doubts(2, {0.02, 0.0});
  ASSERT_TRUE(matcher.Match(View(0), others, sure));
  ASSERT_TRUE(matcher.Match(View(0), others, unsure, doubts));
  double sum_sure = 0, sum_unsure = 0;
  for (std::size_t i = 0; i < sure.range_m.size(); ++i) {
    if (std::isnan(sure.range_m[i]) || std::isnan(unsure.range_m[i])) continue;
    sum_sure += static_cast<double>(sure.sd_m[i] / sure.range_m[i]);
    sum_unsure += static_cast<double>(unsure.sd_m[i] / unsure.range_m[i]);
  }
  EXPECT_GT(sum_unsure, 1.2 * sum_sure);
}

// As when the robot stands: the picture from the same place is of no use, the others are.
TEST_F(MultiMatcherTest, APictureFromTheSamePlaceIsLeftOut) {
  MultiMatcher matcher({});
  RangeImage with, without;
  std::vector<StereoView> others = Others(2);
  ASSERT_TRUE(matcher.Match(View(0), others, without));
  others.insert(others.begin() + 1, View(0));
  ASSERT_TRUE(matcher.Match(View(0), others, with));
  ExpectSame(with, without);
  ASSERT_EQ(matcher.of_pairs().size(), 3U);
  EXPECT_TRUE(matcher.of_pairs()[1].range_m.empty());
}

TEST_F(MultiMatcherTest, PicturesFromTheSamePlaceOnlyAreAnError) {
  MultiMatcher matcher({});
  RangeImage ranges;
  const StereoView same = View(0);
  const auto done = matcher.Match(View(0), std::span(&same, 1), ranges);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_FALSE(matcher.Match(View(0), {}, ranges));
}

}  // namespace
}  // namespace kawara::vision
