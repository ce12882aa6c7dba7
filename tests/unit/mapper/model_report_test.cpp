#include "onboard/mapper/model_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <regex>

#include "tests/support/test_folder.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWidth = 64, kHeight = 32;
constexpr double kTruthM = 4.0;

class ModelReportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto model =
        vision::EquirectangularCamera::Create(vision::PanoramaGeometry::Full(kWidth, kHeight));
    ASSERT_TRUE(model) << model.error().message;
    const auto shared = std::make_shared<const vision::EquirectangularCamera>(std::move(*model));
    camera_ = std::make_unique<vision::StereoCamera>(shared);
    auto picture = std::make_shared<survey::Picture>();
    picture->width_px = kWidth;
    picture->height_px = kHeight;
    picture->rgb.assign(picture->view().size_bytes(), 99);
    picture_ = picture;
    fs::create_directories(survey_ / "range");
    options_.out = folder_ / "model";
    WriteModel();
  }
  // One tile with one triangle, as the mapper leaves it.
  void WriteModel() const {
    auto store = ModelStore::Open(options_.out, {"a source", "options"}, {}, false);
    ASSERT_TRUE(store) << store.error().message;
    core::TexturedMesh mesh;
    mesh.positions_m = {{0, 0, 0}, {2, 0, 0}, {2, 3, 0.5F}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.colours.assign(3, {200, 10, 10});
    mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
    ASSERT_TRUE(store->WriteTile(0, 0, 1, mesh, {}));
    ASSERT_TRUE(store->WriteIndex(1, 1, 1, {}));
  }
  void WriteTruth(const std::string& frame, int width_px = kWidth) const {
    const cv::Mat levels(kHeight, width_px, CV_16UC1, cv::Scalar(1000.0 * kTruthM));
    ASSERT_TRUE(cv::imwrite((survey_ / "range" / (frame + ".png")).string(), levels));
  }
  PicturePair Pair(std::uint64_t stop, const std::string& name, std::size_t camera = 0) const {
    PicturePair pair;
    pair.stop = stop;
    pair.time = core::GpsTime::FromNs(1'400'000'000'000'000'000);
    pair.camera = camera;
    pair.name = name;
    pair.picture_a = pair.picture_b = picture_;
    pair.map_from_a.translation() = Eigen::Vector3d(0.25 * static_cast<double>(stop), 0, 0);
    pair.map_from_b.translation() = pair.map_from_a.translation() + Eigen::Vector3d(0.5, 0, 0);
    return pair;
  }
  vision::RangeImage Ranges(float error_m) const {
    vision::RangeImage ranges;
    ranges.Reset(kWidth, kHeight);
    for (std::size_t i = 0; i < ranges.range_m.size(); i += 2) {
      ranges.range_m[i] = static_cast<float>(kTruthM) + error_m;
      ranges.sd_m[i] = 0.1F;
    }
    return ranges;
  }
  ModelReport Opened() const {
    auto report = ModelReport::Open(page_, survey_);
    EXPECT_TRUE(report) << report.error().message;
    return std::move(*report);
  }
  std::string PageOf(const ModelReport& report) const {
    const auto written = report.Write(options_, result_, rig_, "a source");
    EXPECT_TRUE(written) << written.error().message;
    std::ifstream file(page_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  testing::TestFolder folder_;
  fs::path survey_ = folder_ / "survey", page_ = folder_ / "pages/report.html";
  std::unique_ptr<vision::StereoCamera> camera_;
  SharedPicture picture_;
  ModelOptions options_;
  ModelResult result_{.pairs = 3, .tiles = 1, .faces = 1, .seconds = 2.0, .vrml = {}, .rig = {}};
  Rig rig_;
};

std::size_t Count(const std::string& text, const std::string& what) {
  const std::regex pattern(what);
  return static_cast<std::size_t>(std::distance(
      std::sregex_iterator(text.begin(), text.end(), pattern), std::sregex_iterator()));
}

TEST_F(ModelReportTest, RangesAreComparedWhereTheTruthIsKnown) {
  WriteTruth("00001");
  ModelReport report = Opened();
  report.Measured(Pair(0, "00001"), *camera_, Ranges(0.05F));
  report.Measured(Pair(1, "00002"), *camera_, Ranges(0.05F));
  const std::string page = PageOf(report);
  EXPECT_THAT(page, HasSubstr("<h2>Accuracy</h2>\n<p>1 distance image."));
  EXPECT_THAT(page, HasSubstr("<td>50.0 mm</td>"));  // bias at 2-6 m
}

TEST_F(ModelReportTest, WithoutTruthThereIsNoAccuracy) {
  ModelReport report = Opened();
  report.Measured(Pair(0, "00001"), *camera_, Ranges(0.0F));
  const std::string page = PageOf(report);
  EXPECT_THAT(page, Not(HasSubstr("Accuracy")));
  EXPECT_THAT(page, HasSubstr("50.0 %"));  // every second pixel has a range
}

TEST_F(ModelReportTest, ATruthThatDoesNotFitIsAWarningAndNotMore) {
  WriteTruth("00001", kWidth + 1);
  WriteTruth("00002", kWidth + 1);
  ModelReport report = Opened();
  report.Measured(Pair(0, "00001"), *camera_, Ranges(0.0F));
  report.Measured(Pair(1, "00002"), *camera_, Ranges(0.0F));
  const std::string page = PageOf(report);
  EXPECT_THAT(page, Not(HasSubstr("Accuracy")));
  EXPECT_EQ(Count(page, "range/0000.\\.png"), 1U);
}

TEST_F(ModelReportTest, WarningsAreOnThePageAndOtherLinesAreNot) {
  ModelReport report = Opened();
  report.Say("warning: 3 pictures were left out");
  report.Say("goes on with stop 7");
  const std::string page = PageOf(report);
  EXPECT_THAT(page, HasSubstr("<li>3 pictures were left out</li>"));
  EXPECT_THAT(page, Not(HasSubstr("stop 7")));
}

TEST_F(ModelReportTest, ALongDriveOfTwoCamerasIsAFewSamplesOfBoth) {
  ModelReport report = Opened();
  for (std::uint64_t stop = 0; stop < 200; ++stop) {
    report.Measured(Pair(stop, "left/" + std::to_string(stop), 0), *camera_, Ranges(0.0F));
    report.Measured(Pair(stop, "right/" + std::to_string(stop), 1), *camera_, Ranges(0.0F));
  }
  const std::string page = PageOf(report);
  const std::size_t left = Count(page, ">left/\\d+<"), right = Count(page, ">right/\\d+<");
  EXPECT_EQ(left, right);
  EXPECT_GE(left, 2U);
  EXPECT_LE(left + right, 8U);
  EXPECT_THAT(page, HasSubstr("49.8 m"));  // 199 steps of a quarter of a metre
}

TEST_F(ModelReportTest, TheModelIsShownAndLinkedFromWhereThePageLies) {
  const std::string page = PageOf(Opened());
  EXPECT_THAT(page, HasSubstr("href=\"./../model/model.wrl\""));
  EXPECT_THAT(page, HasSubstr("From above; north is up"));
}

TEST_F(ModelReportTest, ATileThatIsGoneIsAnErrorAndNoPage) {
  fs::remove(options_.out / "tile_0_0.ply");
  const ModelReport report = Opened();
  const auto written = report.Write(options_, result_, rig_, "a source");
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, HasSubstr("tile_0_0.ply"));
  EXPECT_FALSE(fs::exists(page_));
}

TEST_F(ModelReportTest, APageThatCannotBeWrittenIsRefusedAtOnce) {
  const auto report = ModelReport::Open(survey_, survey_);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("--report"));
}

}  // namespace
}  // namespace kawara::mapper
