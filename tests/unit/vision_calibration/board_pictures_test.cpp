#include <gtest/gtest.h>

#include <limits>

#include "tests/support/board_scene.hpp"
#include "tests/unit/vision_calibration/camera_miss.hpp"
#include "tests/unit/vision_calibration/known_cameras.hpp"
#include "vision/calibration/board_finder.hpp"
#include "vision/calibration/calibrator.hpp"

/// From rendered pictures of a board, blurred and noisy, to the camera that made them.
namespace kawara::vision {
namespace {

constexpr double kTolerancePx = 0.05;
const Board kBoard{.cols = 9, .rows = 6, .square_m = 0.03};

/// Distances of found corners from the nearest true ones [px]. A corner beyond the field of view
/// has none: it is the calibration's to leave out.
void AddMisses(const BoardView& found, const BoardView& truth, std::vector<double>& misses) {
  for (const BoardCorner& corner : found) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const BoardCorner& other : truth) {
      nearest = std::min(nearest, (corner.pixel_px - other.pixel_px).norm());
    }
    misses.push_back(nearest);
  }
}

/// The other models differ from these in what the corners' test sees as well.
std::vector<KnownCamera> RenderedCameras() {
  std::vector<KnownCamera> cameras = KnownCameras();
  std::erase_if(cameras, [](const KnownCamera& known) {
    return known.model == CalibrationModel::kDoughnut || known.model == CalibrationModel::kEucm;
  });
  return cameras;
}

class RenderedBoards : public testing::TestWithParam<KnownCamera> {};

TEST_P(RenderedBoards, GiveTheCameraThatMadeThem) {
  const KnownCamera& known = GetParam();
  const auto truth = MakeCamera(known.choice);
  ASSERT_TRUE(truth) << truth.error().message;
  std::mt19937 random(1);
  std::vector<BoardView> views;
  std::vector<double> misses;
  unsigned seed = 0;
  for (const BoardHold& hold : HoldsAround(known.low_rad, known.high_rad, 24, 3)) {
    const Eigen::Isometry3d pose = CameraFromBoard(**truth, kBoard, hold);
    const RgbPicture picture = RenderBoard(**truth, kBoard, pose, {}, ++seed);
    const FoundBoard found = FindBoard(picture.view(), kBoard);
    if (found.view.empty()) continue;
    AddMisses(found.view, SeenCorners(**truth, kBoard, pose, 0, random), misses);
    views.push_back(found.view);
  }
  ASSERT_GE(views.size(), 20U);
  std::ranges::sort(misses);
  EXPECT_LT(misses[misses.size() / 2], 0.04);
  EXPECT_LT(misses[misses.size() * 95 / 100], 0.1);
  CalibrationOptions options;
  options.picture = {kSidePx, kSidePx, known.mirrored, known.axis};
  options.square_m = kBoard.square_m;
  const auto calibrator = Calibrator::Create(options, views);
  ASSERT_TRUE(calibrator) << calibrator.error().message;
  const auto made = calibrator->Calibrate(known.model);
  ASSERT_TRUE(made) << made.error().message;
  const auto camera = MakeCamera(made->optics);
  ASSERT_TRUE(camera) << camera.error().message;
  const double miss_px = MissPx(**truth, **camera, made->coverage);
  EXPECT_LT(miss_px, kTolerancePx);
  EXPECT_LT(made->fit.rms_px, 0.1);
}

INSTANTIATE_TEST_SUITE_P(BoardPictures, RenderedBoards, testing::ValuesIn(RenderedCameras()),
                         [](const auto& camera) {
                           std::string name = NameOf(camera.param.model);
                           std::erase(name, '-');
                           return name;
                         });

TEST(BoardPictures, WithoutABoardNothingIsFound) {
  RgbPicture picture;
  picture.width_px = picture.height_px = 400;
  picture.rgb.resize(picture.view().size_bytes());
  std::mt19937 random(5);
  for (auto& byte : picture.rgb) byte = static_cast<std::uint8_t>(random());
  EXPECT_TRUE(FindBoard(picture.view(), kBoard).view.empty());
}

}  // namespace
}  // namespace kawara::vision
