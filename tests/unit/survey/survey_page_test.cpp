#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "onboard/survey/calibration_file.hpp"
#include "onboard/survey/pose_table.hpp"
#include "onboard/survey/survey_config.hpp"

/// docs/survey_format.md shows what is read: every example of it is.
namespace kawara::survey {
namespace {

std::multimap<std::string, std::string> Examples() {
  std::ifstream page(std::string(KAWARA_SOURCE_DIR) + "/docs/survey_format.md");
  std::multimap<std::string, std::string> examples;
  std::string name, text;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```") && name.empty()) {
      name = line.substr(line.find(' ') + 1);
      text.clear();
    } else if (line == "```") {
      examples.emplace(name, text);
      name.clear();
    } else if (!name.empty()) {
      text += line + "\n";
    }
  }
  return examples;
}

std::vector<std::string> ExamplesOf(const std::string& name) {
  std::vector<std::string> texts;
  const auto all = Examples();
  for (auto [it, end] = all.equal_range(name); it != end; ++it) texts.push_back(it->second);
  return texts;
}

TEST(SurveyPage, CameraFilesAreRead) {
  const auto texts = ExamplesOf("camera.yaml");
  ASSERT_EQ(texts.size(), 3U);
  std::size_t cameras = 0;
  for (const std::string& text : texts) {
    const auto config = ParseSurveyConfig(text, "camera.yaml");
    ASSERT_TRUE(config) << config.error().message;
    for (const CameraConfig& camera : config->cameras) {
      ++cameras;
      if (!camera.calibration.empty()) continue;
      const auto model = vision::MakeCamera(camera.optics);
      EXPECT_TRUE(model) << model.error().message;
    }
  }
  EXPECT_EQ(cameras, 4U);
}

TEST(SurveyPage, PosesAreRead) {
  std::vector<std::string> texts = ExamplesOf("poses.csv");
  ASSERT_EQ(texts.size(), 2U);
  texts.push_back(ExamplesOf("poses.txt").at(0));
  for (const std::string& text : texts) {
    const auto poses = ParsePoses(text, "poses", BodyAxes::kForwardRightDown);
    ASSERT_TRUE(poses) << poses.error().message;
    EXPECT_EQ(poses->rows.size(), 2U);
    EXPECT_TRUE(poses->rows[0].time.IsSet());
  }
}

TEST(SurveyPage, CalibrationsAreRead) {
  const std::map<std::string, std::vector<std::string>> expected = {
      {"camchain.yaml", {"mei", "kb4"}},
      {"calibration.json", {"double_sphere"}},
      {"opencv.yaml", {"mei"}},
      {"calib_results.txt", {"ocam"}}};
  for (const auto& [name, models] : expected) {
    const auto calibrations = ParseCalibration(ExamplesOf(name).at(0), name);
    ASSERT_TRUE(calibrations) << calibrations.error().message;
    ASSERT_EQ(calibrations->size(), models.size()) << name;
    for (std::size_t i = 0; i < models.size(); ++i) {
      EXPECT_EQ((*calibrations)[i].optics.camera, models[i]) << name;
      const auto camera = vision::MakeCamera((*calibrations)[i].optics);
      EXPECT_TRUE(camera) << name << ": " << camera.error().message;
    }
  }
}

}  // namespace
}  // namespace kawara::survey
