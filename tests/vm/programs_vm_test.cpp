// kawara-camera and kawara-onboard as a user starts them, on the kernel's test camera.
#include <filesystem>
#include <regex>

#include "tests/vm/command.hpp"
#include "tests/vm/vivid.hpp"

namespace kawara::drivers {
namespace {

namespace fs = std::filesystem;
using vm::Answer;
using vm::Command;
using vm::Has;

TEST(KawaraCamera, ListsWhatIsThere) {
  const Answer list = Command("kawara-camera list");
  EXPECT_EQ(list.status, 0);
  EXPECT_TRUE(Has(list, "/dev/video0: vivid, driver vivid, bus platform:vivid-000")) << list.text;
  EXPECT_TRUE(Has(list, "bus platform:vivid-001, multi-planar")) << list.text;
  EXPECT_TRUE(Has(list, "/dev/video1 (vivid): not a capture device: it is an output")) << list.text;
  EXPECT_TRUE(Has(list, "320x180      60 50 40")) << list.text;
}

TEST(KawaraCamera, ShowsAndSetsControls) {
  const Answer set =
      Command("kawara-camera controls -d /dev/video0 brightness=77 test_pattern='Gray Ramp'");
  EXPECT_EQ(set.status, 0) << set.text;
  EXPECT_TRUE(std::regex_search(set.text, std::regex("brightness +77: 0..255"))) << set.text;
  EXPECT_TRUE(std::regex_search(set.text, std::regex("test_pattern +20 \\(Gray Ramp\\)")));
  const Answer wrong = Command("kawara-camera controls -d /dev/video0 brightness=300");
  EXPECT_EQ(wrong.status, 2);
  EXPECT_TRUE(Has(wrong, "control brightness = 300: expected 0..255")) << wrong.text;
  EXPECT_EQ(Command("kawara-camera controls -d /dev/video0 brightness=128 test_pattern=0").status,
            0);
}

TEST(KawaraCamera, GrabsPictures) {
  for (const char* const file : {"/tmp/grabbed.jpg", "/tmp/grabbed.png"}) {
    const Answer grab =
        Command(std::string("kawara-camera grab -d /dev/video0 --size 320x180 --skip 1 ") + file);
    EXPECT_EQ(grab.status, 0) << grab.text;
    EXPECT_GT(fs::file_size(file), 1000U);
  }
  EXPECT_EQ(Command("kawara-camera grab -d /dev/video0 --size 320x180 /nowhere/a.png").status, 2);
}

TEST(KawaraCamera, MeasuresStreams) {
  const Answer stream =
      Command("kawara-camera stream -d /dev/video0 --size 320x180 --rate 30 -n 20");
  EXPECT_EQ(stream.status, 0) << stream.text;
  EXPECT_TRUE(Has(stream, "20 frames")) << stream.text;
  EXPECT_TRUE(Has(stream, "between exposures")) << stream.text;
}

TEST(KawaraCamera, SaysWhatIsWrong) {
  const std::pair<const char*, const char*> cases[] = {
      {"stream", "several cameras: /dev/video0 /dev/video2; say which with --device"},
      {"stream -d /dev/video9", "plugged in?"},
      {"stream -d /dev/video1", "it is an output"},
      {"stream -d /dev/null", "not a capture device"},
      {"stream -d /tmp", "not a device"},
      {"stream -d nobody --patience 1", "no capture device of this bus or name"},
      {"stream -d /dev/video0 --format MJPG", "it offers: YUYV 320x180"},
      {"stream -d /dev/video0 --size 333x222", "does not offer"},
      {"stream -d /dev/video0 --size 333", "expected WIDTHxHEIGHT"},
      {"stream -d /dev/video0 --set nonsense=1", "has no control \"nonsense\""},
  };
  for (const auto& [words, part] : cases) {
    const Answer answer = Command(std::string("kawara-camera ") + words);
    EXPECT_EQ(answer.status, 2) << words;
    EXPECT_TRUE(Has(answer, part)) << words << ": " << answer.text;
    EXPECT_EQ(std::count(answer.text.begin(), answer.text.end(), '\n'),
              Has(answer, "no capture device of this bus") ? 2 : 1)
        << answer.text;
  }
  Watched holder(SmallConfig());
  ASSERT_TRUE(holder.Next());
  const Answer busy = Command("kawara-camera stream -d /dev/video0 --size 320x180 --patience 1");
  EXPECT_EQ(busy.status, 2);
  EXPECT_TRUE(Has(busy, "another program streams from it")) << busy.text;
}

/// The robot's own program with this camera and no other instrument: it takes pictures by its own
/// clock, loses the camera and gets it back.
TEST(KawaraOnboard, TakesPicturesAndSurvivesUnplugging) {
  {
    std::ofstream config("/tmp/robot.yaml");
    config << "robot: {name: vm}\n"
              "gps: {device: /dev/none_gps, baud_bps: 115200, profile: nmea,\n"
              "      pps: {device: /dev/pps0}}\n"
              "ahrs: {device: /dev/none_ahrs, model: 100}\n"
              "camera:\n"
              "  source: v4l2\n"
              "  v4l2: {device: /dev/video0, width_px: 320, height_px: 180, rate_hz: 10,\n"
              "         controls: {test_pattern: 0}, reconnect_s: 0.2}\n"
              "picture:\n"
              "  camera: doughnut\n"
              "  doughnut: {width_px: 320, height_px: 180, center_u_px: 159.5, center_v_px: 89.5,\n"
              "             l_in_px: 20, l_base_px: 45, l_out_px: 88, phi_top_deg: 30,\n"
              "             phi_bottom_deg: -50}\n"
              "  panorama: {width_px: 512}\n"
              "  quality: 80\n"
              "  preview_width_px: 128\n"
              "  preview_quality: 50\n"
              "schedule: {every_epochs: 1, free_run_period_s: 0.5, free_run_after_s: 1}\n"
              "record: {folder: /tmp/log, disk_reserve_mb: 0}\n";
  }
  const Answer check = Command("kawara-onboard --config /tmp/robot.yaml --check");
  EXPECT_EQ(check.status, 1) << check.text;  // its two serial ports are not there
  EXPECT_TRUE(Has(check, "good   camera /dev/video0: sends pictures: /dev/video0: vivid"))
      << check.text;
  EXPECT_TRUE(Has(check, "weak   pulse /dev/pps0: is there, but no pulse")) << check.text;
  EXPECT_TRUE(Has(check, "2 wrong")) << check.text;
  Answer robot;
  std::thread program(
      [&robot] { robot = Command("kawara-onboard --config /tmp/robot.yaml --duration 25"); });
  std::this_thread::sleep_for(std::chrono::seconds(10));
  Unplug();
  std::this_thread::sleep_for(std::chrono::seconds(3));
  Replug();
  program.join();
  ASSERT_EQ(robot.status, 0) << robot.text;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(
      robot.text, found, std::regex(" ([0-9]+) pictures \\(([0-9]+) triggers without frame\\)")))
      << robot.text;
  // Without a frame are only the triggers of the seconds without camera.
  EXPECT_GT(std::stoi(found[1]), 20) << robot.text;
  EXPECT_GT(std::stoi(found[1]), 2 * std::stoi(found[2])) << robot.text;

  const Answer events = Command("kawara-log export --channel EVENT --out - /tmp/log");
  EXPECT_TRUE(Has(events, "/dev/video0: vivid (platform:vivid-000), NV12 320x180 at 10 Hz"))
      << events.text;
  EXPECT_TRUE(Has(events, "(unplugged?)")) << events.text;
  EXPECT_TRUE(Has(events, "the pulse line is there")) << events.text;
  const std::size_t there = events.text.find("camera is there");
  EXPECT_NE(events.text.find("camera is there", there + 1), std::string::npos) << events.text;
  const Answer replay = Command("kawara-onboard --log /tmp/log --out /tmp/replayed.lcm");
  EXPECT_EQ(replay.status, 0) << replay.text;
  EXPECT_TRUE(Has(replay, " " + found[1].str() + " pictures")) << robot.text << replay.text;
}

}  // namespace
}  // namespace kawara::drivers
