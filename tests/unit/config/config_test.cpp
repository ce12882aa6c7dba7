#include "core/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace kawara::core::config {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

enum class Parity { kNone, kEven, kOdd };
constexpr auto ConfigNames(Parity) {
  return std::array{EnumName<Parity>{Parity::kNone, "none"},
                    EnumName<Parity>{Parity::kEven, "even"}, EnumName<Parity>{Parity::kOdd, "odd"}};
}

struct PortConfig {
  std::string device = "/dev/null";
  int baud_bps = 38400;
  Parity parity = Parity::kNone;
  Duration timeout_s = Milliseconds(2500);
  template <class V>
  void Visit(V& v) {
    v("device", device, NotEmpty{});
    v("baud_bps", baud_bps, Range{300, 921600});
    v("parity", parity, Optional{});
    v("timeout_s", timeout_s, Range{0.1, 60.0}, Optional{});
  }
  bool operator==(const PortConfig&) const = default;
};

struct CameraConfig {
  std::string name = "front";
  double gain_db = 0.0;
  std::vector<int> exposure_us{100};
  template <class V>
  void Visit(V& v) {
    v("name", name, OneOf{"front", "rear"});
    v("gain_db", gain_db, Range{-10.0, 10.0});
    v("exposure_us", exposure_us, Range{20, 20000}, NotEmpty{}, Optional{});
  }
  bool operator==(const CameraConfig&) const = default;
};

struct RobotConfig {
  PortConfig gps;
  std::vector<CameraConfig> cameras;
  std::array<double, 3> lever_arm_frd_m{};
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::uint8_t id = 0;
  bool dry_run = false;
  std::optional<double> declination_deg;
  std::vector<std::string> tags;
  NamedTexts knobs;
  double low = 0.0, high = 1.0;
  template <class V>
  void Visit(V& v) {
    v("gps", gps);
    v("cameras", cameras, Optional{});
    v("lever_arm_frd_m", lever_arm_frd_m, Range{-10, 10}, Optional{});
    v("origin_m", origin_m, Optional{});
    v("id", id, Optional{});
    v("dry_run", dry_run, Optional{});
    v("declination_deg", declination_deg, Range{-180, 180});
    v("tags", tags, Optional{});
    v("knobs", knobs, Optional{});
    v("low", low, Optional{});
    v("high", high, Optional{});
    v.Require(low < high, "high", "more than low");
  }
  bool operator==(const RobotConfig&) const = default;
};

const std::string kGood = "gps:\n  device: /dev/ttyGPS\n  baud_bps: 115200\n";

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\n') {
      lines.emplace_back();
    } else {
      lines.back() += c;
    }
  }
  return lines;
}

std::vector<std::string> Mistakes(const std::string& yaml,
                                  const std::vector<std::string>& set = {}) {
  const auto config = Parse<RobotConfig>(yaml, "r.yaml", set);
  return config ? std::vector<std::string>{} : Lines(config.error().message);
}

TEST(Config, ReadsEveryKindOfField) {
  const auto config = Parse<RobotConfig>(R"(
gps: {device: "/dev/ttyGPS", baud_bps: 0x2580, parity: even, timeout_s: 0.25}
cameras:
  - name: rear
    gain_db: -1.5e0
  - {name: front, gain_db: +3, exposure_us: [20, 20000]}
lever_arm_frd_m: [0.12, -0.18, -0.92]
origin_m: [1, 2, 3]
id: 255
dry_run: true
declination_deg: -7.5
tags: [a, 12, "true", '']
knobs: {white_balance: true, gain: 12, "a b": "x: y"}
)",
                                         "r.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->gps, (PortConfig{"/dev/ttyGPS", 9600, Parity::kEven, Milliseconds(250)}));
  ASSERT_EQ(config->cameras.size(), 2u);
  EXPECT_EQ(config->cameras[0], (CameraConfig{"rear", -1.5, {100}}));
  EXPECT_EQ(config->cameras[1], (CameraConfig{"front", 3.0, {20, 20000}}));
  EXPECT_EQ(config->lever_arm_frd_m, (std::array{0.12, -0.18, -0.92}));
  EXPECT_EQ(config->origin_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(config->id, 255);
  EXPECT_TRUE(config->dry_run);
  EXPECT_EQ(config->declination_deg, -7.5);
  EXPECT_THAT(config->tags, ElementsAre("a", "12", "true", ""));
  EXPECT_EQ(config->knobs,
            (NamedTexts{{"white_balance", "true"}, {"gain", "12"}, {"a b", "x: y"}}));
  EXPECT_EQ(Parse<RobotConfig>(Dump(*config), "dump")->knobs, config->knobs);
}

TEST(Config, OptionalKeysKeepTheirDefaults) {
  const auto config = Parse<RobotConfig>(kGood, "r.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->gps.timeout_s, Milliseconds(2500));
  EXPECT_FALSE(config->declination_deg.has_value());
}

struct WrongCase {
  const char* yaml;
  const char* mistake;
};

/// One mistake, one line, with the place of the value (or of the key, where the key is what is
/// wrong).
class ConfigMistake : public ::testing::TestWithParam<WrongCase> {};
TEST_P(ConfigMistake, IsReportedAtItsPlace) {
  EXPECT_THAT(Mistakes(GetParam().yaml), ElementsAre(GetParam().mistake));
}
#define GPS "gps: {device: a, baud_bps: 9600}\n"
INSTANTIATE_TEST_SUITE_P(
    Table, ConfigMistake,
    ::testing::Values(
        WrongCase{GPS "knobs: {a: [1]}", "r.yaml:2:12: knobs.a = [...]: expected a single value"},
        WrongCase{GPS "knobs: [a, b]",
                  "r.yaml:2:8: knobs = [...]: expected a section {name: value, ...}"},
        WrongCase{"gps:\n  device: a\n  baud_bps: 3\n",
                  "r.yaml:3:13: gps.baud_bps = 3: expected 300..921600"},
        WrongCase{"gps:\n  device: a\n  baud_bps: fast\n",
                  "r.yaml:3:13: gps.baud_bps = fast: expected a whole number 300..921600"},
        WrongCase{"gps:\n  device: a\n  baud_bps: \"9600\"\n",
                  "r.yaml:3:13: gps.baud_bps = \"9600\": expected a whole number 300..921600"},
        WrongCase{"gps:\n  device: a\n  baud_bps: 9600.5\n",
                  "r.yaml:3:13: gps.baud_bps = 9600.5: expected a whole number 300..921600"},
        WrongCase{"gps:\n  device: a\n  baud_bps: 99999999999999999999\n",
                  "r.yaml:3:13: gps.baud_bps = 99999999999999999999: expected 300..921600"},
        WrongCase{"gps:\n  device:\n  baud_bps: 9600\n",
                  "r.yaml:2:3: gps.device = (nothing): expected text (not empty)"},
        WrongCase{"gps:\n  device: ''\n  baud_bps: 9600\n",
                  "r.yaml:2:11: gps.device = \"\": expected text (not empty)"},
        WrongCase{"gps:\n  device: a\n",
                  "r.yaml:2:3: gps.baud_bps: missing: expected a whole number 300..921600"},
        WrongCase{"id: 1\n",
                  "r.yaml:1:1: gps: missing: expected a section with device, baud_bps, parity, "
                  "timeout_s"},
        WrongCase{
            "gps: 5\n",
            "r.yaml:1:6: gps = 5: expected a section with device, baud_bps, parity, timeout_s"},
        WrongCase{"gps:\n  devise: a\n  device: b\n  baud_bps: 9600\n",
                  "r.yaml:2:3: gps.devise = a: unknown key: expected gps.device?"},
        WrongCase{
            GPS "colour_of_the_paint: red\n",
            "r.yaml:2:1: colour_of_the_paint = red: unknown key: expected one of gps, cameras, "
            "lever_arm_frd_m, origin_m, id, dry_run, declination_deg, tags, knobs, low, high"},
        WrongCase{"gps:\n  device: a\n  baud_bps: 9600\n  device: b\n",
                  "r.yaml:4:3: gps.device = b: duplicate key: expected once (first at line 2)"},
        WrongCase{"gps: {device: a, baud_bps: 9600, parity: evne}\n",
                  "r.yaml:1:42: gps.parity = evne: expected one of none, even, odd"},
        WrongCase{"gps: {device: a, baud_bps: 9600, timeout_s: 2 s}\n",
                  "r.yaml:1:45: gps.timeout_s = 2 s: expected a number of seconds 0.1..60"},
        WrongCase{"gps: {device: a, baud_bps: 9600, timeout_s: 0}\n",
                  "r.yaml:1:45: gps.timeout_s = 0: expected 0.1..60"},
        WrongCase{GPS "id: 256\n", "r.yaml:2:5: id = 256: expected 0..255"},
        WrongCase{GPS "id: -1\n", "r.yaml:2:5: id = -1: expected 0..255"},
        WrongCase{GPS "dry_run: yes\n", "r.yaml:2:10: dry_run = yes: expected true or false"},
        WrongCase{GPS "low: .nan\n", "r.yaml:2:6: low = .nan: expected a number"},
        WrongCase{GPS "low: nan\n", "r.yaml:2:6: low = nan: expected a number"},
        WrongCase{GPS "low: 1e999\n", "r.yaml:2:6: low = 1e999: expected a number"},
        WrongCase{GPS "low: 5\n", "r.yaml:1:1: high: expected more than low"},
        WrongCase{GPS "high: -5\n", "r.yaml:2:7: high = -5: expected more than low"},
        WrongCase{
            GPS "lever_arm_frd_m: [1, 2]\n",
            "r.yaml:2:18: lever_arm_frd_m = [...]: expected a list of 3, each a number -10..10"},
        WrongCase{GPS "lever_arm_frd_m: [1, 2, 11]\n",
                  "r.yaml:2:25: lever_arm_frd_m[2] = 11: expected -10..10"},
        WrongCase{GPS "cameras: [{name: up, gain_db: 0}]\n",
                  "r.yaml:2:18: cameras[0].name = up: expected one of front, rear"},
        WrongCase{GPS "cameras: [{name: rear, gain_db: 0, exposure_us: [50, 5]}]\n",
                  "r.yaml:2:54: cameras[0].exposure_us[1] = 5: expected 20..20000"},
        WrongCase{
            GPS "cameras: [{name: rear, gain_db: 0, exposure_us: []}]\n",
            "r.yaml:2:49: cameras[0].exposure_us = [...]: expected a list (not empty), each a "
            "whole number 20..20000"},
        WrongCase{GPS "tags: a\n", "r.yaml:2:7: tags = a: expected a list, each text"},
        WrongCase{GPS "---\nlow: 1\n",
                  "r.yaml:3:1: second YAML document: expected one (remove the --- before it)"},
        WrongCase{"[1, 2]\n",
                  "r.yaml:1:1: [...]: expected a section with gps, cameras, lever_arm_frd_m, "
                  "origin_m, id, "
                  "dry_run, declination_deg, tags, knobs, low, high"}));

TEST(Config, DuplicateInsideAListHasItsPath) {
  EXPECT_THAT(
      Mistakes(GPS "cameras: [{name: rear, gain_db: 0}, {name: rear, gain_db: 0, name: front}]\n"),
      ElementsAre(
          "r.yaml:2:62: cameras[1].name = front: duplicate key: expected once (first at line 2)"));
}

TEST(Config, AliasesAreRefused) {
  EXPECT_THAT(Mistakes(GPS "tags: &x [a]\nlow: *x\n"),
              ::testing::Contains(HasSubstr("r.yaml:3:6: alias: expected the value itself")));
}

TEST(Config, AllMistakesAtOnceSortedByPlace) {
  const std::string yaml =
      "id: 1000\n"
      "gps:\n"
      "  baud_bps: 1\n"
      "  baud_bps: 2\n"
      "  colour: red\n"
      "lowe: 1\n"
      "dry_run: 3\n";
  const auto mistakes = Mistakes(yaml);
  std::vector<std::string> places;
  for (const auto& line : mistakes) places.push_back(line.substr(0, line.find(": ")));
  EXPECT_THAT(places, ElementsAre("r.yaml:1:5", "r.yaml:3:3", "r.yaml:3:13", "r.yaml:4:3",
                                  "r.yaml:5:3", "r.yaml:6:1", "r.yaml:7:10"));
}

TEST(Config, SyntaxErrorHasItsPlace) {
  for (const char* yaml :
       {"gps:\n  device: a\n baud_bps: 1\n", "gps: {device: a\n", "a: b: c\n", "\t- x\n"}) {
    const auto mistakes = Mistakes(yaml);
    ASSERT_FALSE(mistakes.empty()) << yaml;
    EXPECT_THAT(mistakes.front(), HasSubstr("not YAML: ")) << yaml;
    EXPECT_THAT(mistakes.front(), ::testing::MatchesRegex("r.yaml:[1-4]:[0-9]+: .*"));
  }
}

TEST(Config, EmptyFileSaysWhatBelongsThere) {
  for (const char* yaml : {"", "\n\n", "# only a comment\n", "---\n", "~\n"}) {
    EXPECT_THAT(Mistakes(yaml), ElementsAre(HasSubstr("empty file: expected a section with gps")))
        << yaml;
  }
}

TEST(Config, BinaryAndHugeAndDeepAreRefused) {
  EXPECT_THAT(Mistakes(std::string("gps:\n\0x", 7)),
              ElementsAre("r.yaml:2:1: binary data: expected YAML text"));
  EXPECT_THAT(Mistakes(std::string(2 << 20, ' ')), ElementsAre(HasSubstr("larger than 1 MiB")));
  EXPECT_THAT(Mistakes(std::string(100000, '[')), ElementsAre(HasSubstr("not YAML")));
  EXPECT_THAT(Mistakes("a: " + std::string(100, '[') + std::string(100, ']')),
              ElementsAre(HasSubstr("more than 64 levels")));
}

class ConfigFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = ::testing::TempDir() + "config_test_" + std::to_string(::getpid()) + ".yaml";
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::string path_;
};

TEST_F(ConfigFile, Loads) {
  std::ofstream(path_) << kGood;
  const auto config = Load<RobotConfig>(path_);
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->gps.baud_bps, 115200);
}

TEST_F(ConfigFile, UnreadableSaysHowToMend) {
  const auto missing = Load<RobotConfig>(path_);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.error().message,
            path_ + ": No such file or directory (check the path of the configuration file)");
  const auto directory = Load<RobotConfig>("/tmp");
  ASSERT_FALSE(directory);
  EXPECT_THAT(directory.error().message,
              HasSubstr("/tmp: Is a directory (expected a readable YAML file)"));
}

TEST(ConfigOverride, GoesThroughTheSameValidation) {
  const auto config =
      Parse<RobotConfig>(kGood, "r.yaml",
                         std::vector<std::string>{"gps.device=/dev/x", "declination_deg=1.5",
                                                  "tags=[a, b]", "gps.timeout_s=1"});
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->gps.device, "/dev/x");
  EXPECT_EQ(config->declination_deg, 1.5);
  EXPECT_THAT(config->tags, ElementsAre("a", "b"));
  EXPECT_EQ(config->gps.timeout_s, Seconds(1));
}

TEST(ConfigOverride, MendsAFileThatIsIncompleteOrWrong) {
  EXPECT_THAT(Mistakes("id: 1\n", {"gps.device=a", "gps.baud_bps=9600"}), ElementsAre());
  EXPECT_THAT(Mistakes("gps: {device: a, baud_bps: 1}\n", {"gps.baud_bps=9600"}), ElementsAre());
}

TEST(ConfigOverride, ReachesIntoLists) {
  const std::string yaml =
      kGood + "cameras: [{name: front, gain_db: 0}, {name: rear, gain_db: 0}]\n";
  const auto config = Parse<RobotConfig>(
      yaml, "r.yaml", std::vector<std::string>{"cameras[1].gain_db=4", "cameras.0.gain_db=3"});
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->cameras[0].gain_db, 3);
  EXPECT_EQ(config->cameras[1].gain_db, 4);
}

TEST(ConfigOverride, MistakesNameTheAssignment) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"gps.baud_bps=9", "--set gps.baud_bps=9: gps.baud_bps = 9: expected 300..921600"},
      {"gps.bad_bps=9600",
       "--set gps.bad_bps=9600: gps.bad_bps = 9600: unknown key: expected gps.baud_bps?"},
      {"gps.device=", "--set gps.device=: gps.device = \"\": expected text (not empty)"},
      {"gps", "--set gps: expected dotted.key=value"},
      {"=5", "--set =5: expected dotted.key=value"},
      {"gps..device=5", "--set gps..device=5: expected dotted.key=value"},
      {"tags[0]=5", "--set tags[0]=5: tags = {...}: expected a list, each text"},
      {"gps.device.x=5", "--set gps.device.x=5: x: expected a section above it, not /dev/ttyGPS"},
      {"tags=[a", "--set tags=[a: expected a YAML value after ="},
  };
  for (const auto& [assignment, mistake] : cases) {
    const auto mistakes = Mistakes(kGood, {assignment});
    ASSERT_FALSE(mistakes.empty()) << assignment;
    EXPECT_EQ(mistakes.front(), mistake);
  }
}

TEST(ConfigDump, ReadsBackToTheSame) {
  RobotConfig config;
  config.gps = {"/dev/\"odd\\name\"\n\x01: #ü", 300, Parity::kOdd, Nanoseconds(123456789)};
  config.cameras = {{"rear", 1.0 / 3.0, {20, 30}}, {"front", -1e-7, {20000}}};
  config.lever_arm_frd_m = {0.1, -0.2, 1e-300};
  config.origin_m = {1e9, 0, -5};
  config.id = 7;
  config.declination_deg = -0.1;
  config.tags = {"", "null", "true", "~", "- x"};
  config.high = std::numeric_limits<double>::max();
  const std::string yaml = Dump(config);
  const auto again = Parse<RobotConfig>(yaml, "dump");
  ASSERT_TRUE(again) << again.error().message << "\n" << yaml;
  EXPECT_EQ(*again, config) << yaml;
  EXPECT_EQ(Dump(*again), yaml);
}

TEST(ConfigDump, DurationsReadBackToTheNanosecond) {
  for (const std::int64_t ns :
       {1LL, 99LL, 100000001LL, 59999999999LL, 333333333LL, 60000000000LL}) {
    const Duration original(std::max<std::int64_t>(ns, 100000000));
    RobotConfig config;
    config.gps.timeout_s = original;
    const auto again = Parse<RobotConfig>(Dump(config), "dump");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->gps.timeout_s, original);
  }
}

TEST(ConfigDump, LooksAsOneWouldWriteIt) {
  RobotConfig config;
  config.cameras.resize(1);
  EXPECT_EQ(Dump(config),
            "gps:\n"
            "  device: \"/dev/null\"\n"
            "  baud_bps: 38400\n"
            "  parity: none\n"
            "  timeout_s: 2.5\n"
            "cameras:\n"
            "  - name: \"front\"\n"
            "    gain_db: 0.0\n"
            "    exposure_us: [100]\n"
            "lever_arm_frd_m: [0.0, 0.0, 0.0]\n"
            "origin_m: [0.0, 0.0, 0.0]\n"
            "id: 0\n"
            "dry_run: false\n"
            "tags: []\n"
            "knobs: {}\n"
            "low: 0.0\n"
            "high: 1.0\n");
}

}  // namespace
}  // namespace kawara::core::config
