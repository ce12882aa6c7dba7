// What a robot's YAML says of its camera, down to the driver.
#include <gtest/gtest.h>

#include "core/config/config.hpp"
#include "onboard/camera_source.hpp"

namespace kawara::onboard {
namespace {

core::Expected<CameraConfig> Read(const std::string& yaml) {
  return core::config::Parse<CameraConfig>(yaml, "robot.yaml");
}

TEST(CameraConfiguration, ExampleReachesTheDriver) {
  const auto config =
      core::config::Load<OnboardConfig>(KAWARA_SOURCE_DIR "/configs/camera_robot.yaml");
  ASSERT_TRUE(config) << config.error().message;
  const drivers::V4l2CameraConfig camera = V4l2ConfigOf(config->camera);
  EXPECT_TRUE(camera.device.starts_with("/dev/v4l/by-id/"));
  EXPECT_EQ(camera.mode.width_px, 1920U);
  EXPECT_EQ(camera.mode.height_px, 1080U);
  EXPECT_EQ(camera.mode.rate_hz, 30.0);
  EXPECT_EQ(camera.mode.format, "");
  ASSERT_EQ(camera.controls.size(), 3U);
  EXPECT_EQ(camera.controls[0], (std::pair<std::string, std::string>{"auto_exposure", "1"}));
  EXPECT_EQ(camera.stamps.readout, core::Milliseconds(20));
  EXPECT_EQ(camera.stamps.exposure, core::Milliseconds(3));
  EXPECT_TRUE(config->camera.RunsFreely());
  core::Counters counters;
  const CameraSource source = MakeCamera(*config, counters);
  EXPECT_TRUE(source.camera);
  EXPECT_TRUE(source.watch);  // it keeps the exposure
}

TEST(CameraConfiguration, ReadsBackAsItWasWritten) {
  const auto config = Read(
      "source: v4l2\nv4l2: {device: usb-1, controls: {gain: 3, \"0x00f0f000\": 75% Colorbar}}\n");
  ASSERT_TRUE(config) << config.error().message;
  const auto again = Read(core::config::Dump(*config));
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->v4l2.controls, config->v4l2.controls);
}

TEST(CameraConfiguration, EachFormatTheDriverTakesCanBeWritten) {
  for (const drivers::V4l2PixelFormat& format : drivers::V4l2PixelFormats()) {
    const auto config =
        Read("source: v4l2\nv4l2: {device: usb-1, format: " + std::string(format.name) + "}\n");
    ASSERT_TRUE(config) << config.error().message;
    EXPECT_EQ(V4l2ConfigOf(*config).mode.format, format.name);
  }
}

TEST(CameraConfiguration, MistakesNameTheirPlace) {
  const std::pair<const char*, const char*> cases[] = {
      {"source: v4l2\n", "robot.yaml:1:1: v4l2: expected a section with the camera's device"},
      {"source: usb\n", "source = usb: expected"},
      {"source: v4l2\nv4l2: {device: a, width_px: 640}\n", "both width_px and height_px"},
      {"source: v4l2\nv4l2: {device: a, format: H264}\n", "v4l2.format = H264: expected"},
      {"source: v4l2\nv4l2: {device: a, controls: [gain]}\n",
       "v4l2.controls = [...]: expected a section {name: value, ...}"},
      {"source: v4l2\nv4l2: {device: a, gain: 1}\n", "unknown key"},
      {"source: socket\n", "path: expected the path of the camera's socket"},
  };
  for (const auto& [yaml, part] : cases) {
    const auto config = Read(yaml);
    ASSERT_FALSE(config) << yaml;
    EXPECT_NE(config.error().message.find(part), std::string::npos) << config.error().message;
  }
}

}  // namespace
}  // namespace kawara::onboard
