#include "onboard/mapper/pair_maker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>

#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::mapper {
namespace {

constexpr int kWidth = 64, kHeight = 32;

/// A camera that goes straight ahead in steps of a quarter of a metre, and what became of its
/// pictures.
class PairMakerTest : public ::testing::Test {
 protected:
  PairMakerTest() {
    survey::SurveyCamera camera;
    camera.model = std::make_shared<const vision::EquirectangularCamera>(
        *vision::EquirectangularCamera::Create(vision::PanoramaGeometry::Full(kWidth, kHeight)));
    rig_.cameras = {camera};
    cameras_.push_back(std::make_unique<vision::StereoCamera>(camera.model));
  }
  Stop At(std::uint64_t number) {
    Stop stop;
    stop.number = number;
    stop.time = core::GpsTime::FromNs(1'400'000'000'000'000'000 +
                                      250'000'000 * static_cast<std::int64_t>(number));
    stop.map_from_body.translation() = Eigen::Vector3d(0.25 * static_cast<double>(number), 0, 0);
    const auto load = [this, number]() -> core::Expected<SharedPicture> {
      if (!readable_(number, ++loads_[number])) return core::Fail(core::ErrorCode::kIo, "torn");
      auto picture = std::make_shared<survey::Picture>();
      picture->width_px = kWidth;
      picture->height_px = kHeight;
      picture->rgb.resize(picture->view().size_bytes());
      std::mt19937 dice(static_cast<unsigned>(number));
      for (auto& byte : picture->rgb) byte = static_cast<std::uint8_t>(dice());
      pictures_.emplace_back(picture);
      return picture;
    };
    stop.pictures.push_back({0, std::to_string(number), load});
    return stop;
  }
  std::ptrdiff_t InMemory() const {
    return std::ranges::count_if(pictures_, [](const auto& picture) { return !picture.expired(); });
  }
  /// First stops of the pairs of a drive; `most`: pictures in memory while no pair was.
  std::vector<std::uint64_t> Drive(PairMaker& maker, std::uint64_t stops, std::ptrdiff_t& most) {
    std::vector<std::uint64_t> firsts;
    const auto take = [&](const std::vector<PicturePair>& pairs) {
      for (const PicturePair& pair : pairs) firsts.push_back(pair.stop);
    };
    most = 0;
    for (std::uint64_t i = 0; i < stops; ++i) {
      const auto pairs = maker.Add(At(i));
      EXPECT_TRUE(pairs);
      if (pairs) take(*pairs);
      if (pairs && pairs->empty()) most = std::max(most, InMemory());
    }
    for (auto rest = maker.Finish(); !rest.empty(); rest = maker.Finish()) take(rest);
    return firsts;
  }

  Rig rig_;
  std::vector<std::unique_ptr<vision::StereoCamera>> cameras_;
  std::map<std::uint64_t, int> loads_;
  std::vector<std::weak_ptr<const survey::Picture>> pictures_;
  std::function<bool(std::uint64_t stop, int load)> readable_ = [](std::uint64_t, int) {
    return true;
  };
};

TEST_F(PairMakerTest, EveryStopIsPairedOnceWithTheOneABaselineOn) {
  for (const bool refine : {false, true}) {
    PairMaker maker({.baseline_m = 0.5, .step_m = 0.25, .refine = refine}, rig_, cameras_, 0);
    std::ptrdiff_t most = 0;
    const auto firsts = Drive(maker, 20, most);
    ASSERT_EQ(firsts.size(), 18U) << refine;
    for (std::size_t i = 0; i < firsts.size(); ++i) EXPECT_EQ(firsts[i], i);
  }
}

TEST_F(PairMakerTest, PicturesThatWaitForTheirPairAreNotKept) {
  PairMaker maker({.refine = true}, rig_, cameras_, 0);
  std::ptrdiff_t most = 0;
  Drive(maker, 8, most);
  EXPECT_LE(most, 1);
}

TEST_F(PairMakerTest, APictureThatIsGoneWhenItsTurnComesIsLeftOutAndSaid) {
  readable_ = [](std::uint64_t stop, int load) { return stop != 5 || load == 1; };
  PairMaker maker({.refine = true}, rig_, cameras_, 0);
  std::ptrdiff_t most = 0;
  const auto firsts = Drive(maker, 12, most);
  EXPECT_EQ(std::ranges::count(firsts, 5U), 0);
  EXPECT_EQ(std::ranges::count(firsts, 6U), 1);
  EXPECT_GT(maker.unreadable(), 0U);
  EXPECT_EQ(maker.first_unreadable(), "torn");
}

}  // namespace
}  // namespace kawara::mapper
