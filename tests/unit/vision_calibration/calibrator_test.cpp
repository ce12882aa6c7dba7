#include "vision/calibration/calibrator.hpp"

#include <gtest/gtest.h>

#include "tests/support/board_scene.hpp"
#include "tests/unit/vision_calibration/camera_miss.hpp"
#include "tests/unit/vision_calibration/known_cameras.hpp"

/// Cameras found again from corners that are off by some hundredths of a pixel, judged by where
/// they project directions: numbers may trade against each other.
namespace kawara::vision {
namespace {

constexpr double kCornerSdPx = 0.03;
constexpr double kTolerancePx = 0.05;
constexpr int kPictures = 40;
const Board kBoard{.cols = 9, .rows = 6, .square_m = 0.03};

CalibrationOptions OptionsOf(const KnownCamera& known) {
  CalibrationOptions options;
  options.picture = {kSidePx, kSidePx, known.mirrored, known.axis};
  options.square_m = kBoard.square_m;
  return options;
}

std::vector<BoardView> ViewsOf(const KnownCamera& known, const CameraModel& camera, int pictures,
                               double slant_scale = 1.0) {
  std::mt19937 random(7);
  std::vector<BoardView> views;
  for (BoardHold hold : HoldsAround(known.low_rad, known.high_rad, pictures, 3)) {
    hold.slant_rad *= slant_scale;
    BoardView view =
        SeenCorners(camera, kBoard, CameraFromBoard(camera, kBoard, hold), kCornerSdPx, random);
    if (view.size() >= 12) views.push_back(std::move(view));
  }
  return views;
}

class EveryModel : public testing::TestWithParam<KnownCamera> {};

TEST_P(EveryModel, IsFoundAgainFromCorners) {
  const KnownCamera& known = GetParam();
  const auto truth = MakeCamera(known.choice);
  ASSERT_TRUE(truth) << truth.error().message;
  const auto views = ViewsOf(known, **truth, kPictures);
  ASSERT_GE(views.size(), 15U);
  const auto calibrator = Calibrator::Create(OptionsOf(known), views);
  ASSERT_TRUE(calibrator) << calibrator.error().message;
  const auto made = calibrator->Calibrate(known.model);
  ASSERT_TRUE(made) << made.error().message;
  const auto camera = MakeCamera(made->optics);
  ASSERT_TRUE(camera) << camera.error().message;
  const double miss_px = MissPx(**truth, **camera, made->coverage);
  EXPECT_LT(miss_px, kTolerancePx);
  // What is left is what was put in, and the calibration says honestly how good it is.
  EXPECT_NEAR(made->fit.sd_px, kCornerSdPx, 0.2 * kCornerSdPx);
  EXPECT_LT(miss_px, 3.0 * made->projection_sd_px);
  EXPECT_LT(made->cross_validated_px, 2.0 * kCornerSdPx);
  EXPECT_EQ(made->numbers.size(), static_cast<std::size_t>(made->fit.state.parameters.size()));
}

INSTANTIATE_TEST_SUITE_P(Calibrator, EveryModel, testing::ValuesIn(KnownCameras()),
                         [](const auto& camera) {
                           std::string name = NameOf(camera.param.model);
                           std::erase(name, '-');
                           return name;
                         });

TEST(Calibrator, SaysWhatIsMissing) {
  const KnownCamera known = KnownCameras().back();
  const auto camera = MakeCamera(known.choice);
  const auto few = Calibrator::Create(OptionsOf(known), ViewsOf(known, **camera, 2));
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("2 pictures show the board"), std::string::npos)
      << few.error().message;
}

TEST(Calibrator, ParallelBoardsAreRefused) {
  const KnownCamera known = KnownCameras().back();
  const auto camera = MakeCamera(known.choice);
  std::mt19937 random(7);
  std::vector<BoardView> views;
  // One board at one place but for its distance.
  for (int i = 0; i < 8; ++i) {
    const BoardHold hold{.angle_rad = 0.1, .distance_m = 0.4 + 0.02 * i};
    views.push_back(SeenCorners(**camera, kBoard, CameraFromBoard(**camera, kBoard, hold),
                                kCornerSdPx, random));
  }
  const auto calibrator = Calibrator::Create(OptionsOf(known), views);
  if (!calibrator) return;  // no camera at all is as good an answer
  const auto made = calibrator->Calibrate(known.model);
  ASSERT_FALSE(made) << "sigma " << made->projection_sd_px;
  EXPECT_NE(made.error().message.find("slant"), std::string::npos) << made.error().message;
}

TEST(Calibrator, CornersThatContradictTheRestAreLeftOut) {
  const KnownCamera known = KnownCameras().back();
  const auto camera = MakeCamera(known.choice);
  auto views = ViewsOf(known, **camera, kPictures);
  for (std::size_t i = 0; i < 5; ++i) views[2 * i][i + 3].pixel_px += Eigen::Vector2d(3.0, -2.0);
  const auto calibrator = Calibrator::Create(OptionsOf(known), views);
  ASSERT_TRUE(calibrator) << calibrator.error().message;
  const auto made = calibrator->Calibrate(known.model);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_GE(made->left_out, 5);
  EXPECT_LE(made->left_out, 8);
  EXPECT_NEAR(made->fit.sd_px, kCornerSdPx, 0.2 * kCornerSdPx);
}

}  // namespace
}  // namespace kawara::vision
