#include "onboard/exposure_keeper.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::onboard {
namespace {

/// A mirror camera that obeys: a ring whose light is the scene's times exposure and gain, in a
/// black frame, as grey, RGB or JPEG.
class MirrorCamera {
 public:
  double illumination = 100.0;
  double exposure_s = 0.001, gain = 1.0;
  drivers::PixelFormat format = drivers::PixelFormat::kGrey8;
  bool refuses = false;
  std::vector<core::config::NamedTexts> sets;

  core::Expected<void> Set(const core::config::NamedTexts& controls) {
    if (refuses) return core::Fail(core::ErrorCode::kInvalidArgument, "no");
    sets.push_back(controls);
    for (const auto& [name, value] : controls) {
      if (name == "exposure_time_absolute") exposure_s = std::stod(value) * 1e-4;
      if (name == "gain") gain = std::stod(value) / 16.0;
    }
    return {};
  }
  double Light() const { return std::min(1.0, illumination * exposure_s * gain); }
  drivers::Frame Frame() {
    drivers::Frame frame;
    now_ += core::Milliseconds(200);
    frame.exposure_start = frame.arrival = now_;
    frame.width = frame.height = 256;
    frame.format = format;
    const auto level = static_cast<std::uint8_t>(std::lround(255 * std::pow(Light(), 1 / 2.2)));
    const std::size_t channels = format == drivers::PixelFormat::kGrey8 ? 1 : 3;
    for (int v = 0; v < 256; ++v) {
      for (int u = 0; u < 256; ++u) {
        const double radius = std::hypot(u - 127.5, v - 127.5);
        frame.bytes.insert(frame.bytes.end(), channels,
                           radius >= 30 && radius <= 125 ? level : std::uint8_t{0});
      }
    }
    if (format != drivers::PixelFormat::kJpeg) return frame;
    vision::JpegEncoder encoder;
    const auto jpeg =
        encoder.Encode(vision::ConstImageView{frame.bytes.data(), 256, 256}, {.quality = 90});
    frame.bytes.assign(jpeg->begin(), jpeg->end());
    return frame;
  }

 private:
  core::MonoTime now_ = core::MonoTime::FromNs(1'000'000'000);
};

vision::Phase1PictureConfig Ring() {
  vision::Phase1PictureConfig picture;
  picture.doughnut.width_px = picture.doughnut.height_px = 512;  // calibrated at twice the size
  picture.doughnut.center_u_px = picture.doughnut.center_v_px = 255.5;
  picture.doughnut.l_in_px = 60;
  picture.doughnut.l_out_px = 250;
  return picture;
}

ExposureSettings Settings() {
  ExposureSettings settings;
  settings.enabled = true;
  settings.gain_control = "gain";
  settings.gain_unity = 16.0;
  return settings;
}

TEST(ExposureKeeper, BringsTheRingToTheTargetInEveryFormat) {
  for (const auto format :
       {drivers::PixelFormat::kGrey8, drivers::PixelFormat::kRgb8, drivers::PixelFormat::kJpeg}) {
    MirrorCamera camera;
    camera.format = format;
    core::Counters counters;
    ExposureKeeper keeper(Settings(), Ring(), counters,
                          [&](const auto& controls) { return camera.Set(controls); });
    for (const double illumination : {100.0, 1000.0, 20.0}) {
      camera.illumination = illumination;
      for (int i = 0; i < 25; ++i) keeper.OnFrame(camera.Frame());
      EXPECT_NEAR(std::log(camera.Light() / 0.18), 0.0, 0.25) << illumination;
    }
    EXPECT_LE(camera.exposure_s, 0.005);
    EXPECT_GT(camera.gain, 1.0);  // 5 ms are not enough in the shade
    EXPECT_EQ(counters.Register("camera.exposure.set").value(),
              static_cast<std::int64_t>(camera.sets.size()));
    EXPECT_EQ(counters.Register("camera.exposure.exposure_us").value(),
              std::lround(1e6 * camera.exposure_s));
    EXPECT_EQ(counters.Register("camera.exposure.unreadable").value(), 0);
  }
}

TEST(ExposureKeeper, WithoutGainControlOnlyExposureIsSet) {
  MirrorCamera camera;
  ExposureSettings settings = Settings();
  settings.gain_control.clear();
  core::Counters counters;
  ExposureKeeper keeper(settings, Ring(), counters,
                        [&](const auto& controls) { return camera.Set(controls); });
  camera.illumination = 1.0;
  for (int i = 0; i < 25; ++i) keeper.OnFrame(camera.Frame());
  EXPECT_DOUBLE_EQ(camera.exposure_s, 0.005);
  for (const auto& controls : camera.sets) EXPECT_EQ(controls.size(), 1U);
}

TEST(ExposureKeeper, RefusalsAndUnreadablePicturesAreCounted) {
  MirrorCamera camera;
  camera.refuses = true;
  core::Counters counters;
  ExposureKeeper keeper(Settings(), Ring(), counters,
                        [&](const auto& controls) { return camera.Set(controls); });
  keeper.OnFrame(camera.Frame());
  EXPECT_EQ(counters.Register("camera.exposure.refused").value(), 1);
  drivers::Frame broken = camera.Frame();
  broken.format = drivers::PixelFormat::kJpeg;
  keeper.OnFrame(broken);
  EXPECT_EQ(counters.Register("camera.exposure.unreadable").value(), 1);
}

}  // namespace
}  // namespace kawara::onboard
