#include "vision/auto_exposure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>
#include <vector>

namespace kawara::vision {
namespace {

/// A camera of 10 frames a second in front of a scene whose radiances spread over a factor of 16.
/// What is set shows in the picture after next; the picture is shown by `gamma`, in 8 bits.
class Scene {
 public:
  explicit Scene(double gamma) : gamma_(gamma), pending_(2, ExposureSetting{}) {
    std::mt19937 dice(5);
    std::uniform_real_distribution<double> octaves(-2.0, 2.0);
    for (int i = 0; i < 2000; ++i) radiance_.push_back(std::exp2(octaves(dice)));
  }
  /// Takes a picture, lets the controller see it; the mean light of the picture.
  double Frame(AutoExposure& control, double illumination) {
    now_ += core::Milliseconds(100);
    const ExposureSetting used = pending_.front();
    LightHistogram light;
    for (const double r : radiance_) {
      const double exposed = std::min(1.0, illumination * r * used.product());
      light.Add(static_cast<std::uint8_t>(std::lround(255.0 * std::pow(exposed, 1.0 / gamma_))));
    }
    pending_.pop_front();
    if (const auto next = control.Next(light, now_)) {
      settings.push_back(*next);
      // The camera rounds to its 100 us.
      ExposureSetting real = *next;
      real.exposure_s = std::max(1.0, std::round(real.exposure_s * 1e4)) * 1e-4;
      control.OnSet(real, now_ + core::Milliseconds(30));
    }
    pending_.push_back(control.setting());
    return light.TrimmedMean(gamma_);
  }
  std::vector<ExposureSetting> settings;

 private:
  double gamma_;
  std::deque<ExposureSetting> pending_;
  std::vector<double> radiance_;
  core::MonoTime now_ = core::MonoTime::FromNs(1);
};

AutoExposureConfig Config() {
  AutoExposureConfig config;
  config.settle_s = 0.15;
  return config;
}

bool IsRight(double mean) { return mean > 0.18 / 1.3 && mean < 0.18 * 1.3; }

/// Sun, shade, sun, twilight: right within ten pictures after each step, and quiet from then on.
TEST(AutoExposure, SuddenStepsAreFollowedWithoutSwinging) {
  Scene scene(2.2);
  AutoExposure control(Config(), {0.001, 1.0});
  for (const double illumination : {200.0, 12.0, 800.0, 30.0, 200.0}) {
    int right_after = -1;
    for (int frame = 0; frame < 40; ++frame) {
      const bool right = IsRight(scene.Frame(control, illumination));
      if (right && right_after < 0) right_after = frame;
      if (!right) {
        EXPECT_EQ(right_after, -1) << illumination << ": left again in frame " << frame;
      }
    }
    EXPECT_GE(right_after, 0) << illumination;
    EXPECT_LE(right_after, 10) << illumination;
    const std::size_t before = scene.settings.size();
    for (int frame = 0; frame < 20; ++frame) scene.Frame(control, illumination);
    EXPECT_EQ(scene.settings.size(), before) << illumination;
  }
}

/// Told 2.2, the camera does otherwise: it settles at another brightness, but it settles.
TEST(AutoExposure, SettlesOnCamerasThatAnswerOtherwiseThanTold) {
  for (const double gamma : {1.0, 1.5, 3.0}) {
    Scene scene(gamma);
    AutoExposure control(Config(), {0.001, 1.0});
    for (const double illumination : {200.0, 12.0, 800.0, 30.0, 200.0}) {
      for (int frame = 0; frame < 40; ++frame) scene.Frame(control, illumination);
      const std::size_t before = scene.settings.size();
      for (int frame = 0; frame < 20; ++frame) scene.Frame(control, illumination);
      EXPECT_EQ(scene.settings.size(), before) << gamma << " " << illumination;
    }
  }
}

/// Without gain there is nothing between two steps of the exposure: the nearer one is kept.
TEST(AutoExposure, CoarseStepsWithoutGainAreNoSwing) {
  AutoExposureConfig config = Config();
  config.max_gain = 1.0;
  Scene scene(2.2);
  AutoExposure control(config, {0.001, 1.0});
  for (double illumination = 150.0; illumination < 1500.0; illumination *= 1.07) {
    for (int frame = 0; frame < 20; ++frame) scene.Frame(control, illumination);
    const std::size_t before = scene.settings.size();
    for (int frame = 0; frame < 20; ++frame) scene.Frame(control, illumination);
    EXPECT_EQ(scene.settings.size(), before) << illumination;
  }
}

TEST(AutoExposure, GoesStraightToWhereItGoes) {
  Scene scene(2.2);
  AutoExposure control(Config(), {0.005, 8.0});
  for (int frame = 0; frame < 40; ++frame) scene.Frame(control, 200.0);
  ASSERT_GT(scene.settings.size(), 1U);
  for (std::size_t i = 1; i < scene.settings.size(); ++i) {
    EXPECT_LE(scene.settings[i].product(), scene.settings[i - 1].product() * 1.02);
  }
}

TEST(AutoExposure, BlurLimitsExposureThenGainHelps) {
  AutoExposureConfig config = Config();
  config.max_exposure_s = 0.004;
  Scene scene(2.2);
  AutoExposure control(config, {0.001, 1.0});
  for (int frame = 0; frame < 40; ++frame) scene.Frame(control, 8.0);
  EXPECT_DOUBLE_EQ(control.setting().exposure_s, 0.004);
  EXPECT_GT(control.setting().gain, 1.5);
  for (int frame = 0; frame < 40; ++frame) scene.Frame(control, 400.0);
  EXPECT_LT(control.setting().exposure_s, 0.004);
  EXPECT_LT(control.setting().gain, 1.5);
}

TEST(AutoExposure, ANightLongAtTheLimitCostsNothingInTheMorning) {
  const auto frames_to_right = [](int night) {
    Scene scene(2.2);
    AutoExposure control(Config(), {0.001, 1.0});
    for (int frame = 0; frame < night; ++frame) scene.Frame(control, 1e-4);
    const std::size_t at_limit = scene.settings.size();
    for (int frame = 0; frame < 50; ++frame) scene.Frame(control, 1e-4);
    EXPECT_EQ(scene.settings.size(), at_limit) << "the limit is set once";
    for (int frame = 0; frame < 100; ++frame) {
      if (IsRight(scene.Frame(control, 200.0))) return frame;
    }
    return 100;
  };
  EXPECT_LE(frames_to_right(50), 20);
  EXPECT_EQ(frames_to_right(50), frames_to_right(5000));
}

TEST(AutoExposure, PicturesFromBeforeTheSettingAreNotLookedAt) {
  AutoExposure control(Config(), {0.001, 1.0});
  LightHistogram dark;
  for (int i = 0; i < 100; ++i) dark.Add(30);
  const core::MonoTime now = core::MonoTime::FromNs(1'000'000'000);
  const auto first = control.Next(dark, now);
  ASSERT_TRUE(first);
  control.OnSet(*first, now);
  EXPECT_FALSE(control.Next(dark, now + core::Milliseconds(149)));
  EXPECT_TRUE(control.Next(dark, now + core::Milliseconds(150)));
  EXPECT_FALSE(control.Next(LightHistogram{}, now + core::Seconds(1)));
}

TEST(LightHistogram, MeansOfKnownPictures) {
  std::vector<std::uint8_t> rgb(100 * 100 * 3, 128);
  const ConstImageView picture{rgb.data(), 100, 100};
  EXPECT_NEAR(MeasureLight(picture, {}).TrimmedMean(1.0), 128.0 / 255.0, 1e-12);
  EXPECT_NEAR(MeasureLight(picture, {}).TrimmedMean(2.2), std::pow(128.0 / 255.0, 2.2), 1e-12);
  // A tenth of white, a tenth of black: neither moves it.
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = i % 30 < 3 ? 255 : i % 30 < 6 ? 0 : 128;
  EXPECT_NEAR(MeasureLight(picture, {}).TrimmedMean(1.0), 128.0 / 255.0, 1e-12);
  EXPECT_NEAR(MeasureLight(picture, {}).SaturatedShare(), 0.1, 1e-12);
  EXPECT_EQ(LightHistogram{}.TrimmedMean(1.0), 0.0);
}

TEST(LightHistogram, OnlyTheRingCounts) {
  std::vector<std::uint8_t> grey(200 * 200, 0);
  for (int v = 0; v < 200; ++v) {
    for (int u = 0; u < 200; ++u) {
      const double radius = std::hypot(u - 100, v - 100);
      if (radius >= 40 && radius <= 90) grey[static_cast<std::size_t>(v * 200 + u)] = 90;
    }
  }
  const MeteringArea ring{100, 100, 40, 90};
  const LightHistogram light = MeasureGreyLight(grey.data(), 200, 200, ring);
  EXPECT_EQ(light.count[90], light.total);
  EXPECT_GT(light.total, 1000U);
  EXPECT_LE(MeasureGreyLight(grey.data(), 200, 200, {}).total, std::uint32_t{kMeteredPixels});
  EXPECT_EQ(ring.Scaled(0.5).outer_px, 45);
}

}  // namespace
}  // namespace kawara::vision
