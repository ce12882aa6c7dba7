#include "vision/refine/pose_refiner.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/stereo_lab.hpp"
#include "vision/camera/camera_choice.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/refine/so3.hpp"

namespace kawara::vision {
namespace {

using test_support::StereoLab;

constexpr double kStep = 0.25;
constexpr double kPositionSd = 0.02;
constexpr double kAttitudeSd = 0.1 * core::kRadFromDeg;

/// Pictures of the standard doughnut at three eighths of its size, on a drive with some sway.
struct Drive {
  std::shared_ptr<const CameraModel> model = std::make_shared<DoughnutCamera>(
      *DoughnutCamera::Create(DoughnutParameters{}.Resized(384, 384)));
  StereoCamera camera{model};
  Eigen::Isometry3d body_from_camera = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Isometry3d> truth;
  std::vector<PriorPose> priors;
  std::vector<StereoLab::Frame> frames;

  explicit Drive(int count) {
    body_from_camera.linear() = BodyFromCamera();
    body_from_camera.translation() = Eigen::Vector3d(0.1, 0.0, -0.5);
    test_support::StereoLabOptions options;
    options.samples = 2;
    const StereoLab lab(options);
    std::mt19937 dice(5);
    std::normal_distribution<double> normal;
    const auto normals = [&](double sd) {
      return Eigen::Vector3d(sd * normal(dice), sd * normal(dice), sd * normal(dice));
    };
    Eigen::Matrix3d map_from_frd;
    map_from_frd << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    for (int i = 0; i < count; ++i) {
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      pose.translation() = Eigen::Vector3d(kStep * i - 1.0, 0.02 * std::sin(i), 1.5);
      pose.linear() =
          map_from_frd * Exp({0.0, 0.003 * std::cos(2.0 * i), 0.03 * std::sin(0.5 * i)});
      truth.push_back(pose);
      frames.push_back(lab.Render(*model, pose * body_from_camera, static_cast<std::uint32_t>(i)));
      PriorPose prior;
      prior.map_from_body = pose;
      prior.map_from_body.translation() += normals(kPositionSd);
      prior.map_from_body.linear() = pose.linear() * Exp(normals(kAttitudeSd));
      prior.covariance = Matrix6d::Zero();
      prior.covariance->diagonal() << Eigen::Vector3d::Constant(kPositionSd * kPositionSd),
          Eigen::Vector3d::Constant(kAttitudeSd * kAttitudeSd);
      priors.push_back(prior);
    }
  }
};

/// Made once: rendering takes most of the time.
const Drive& TheDrive() {
  static const Drive drive(12);
  return drive;
}

double TurnError(const Drive& drive, std::size_t a, std::size_t b, const Eigen::Isometry3d& pose_a,
                 const Eigen::Isometry3d& pose_b) {
  const Eigen::Isometry3d truth = drive.truth[a].inverse() * drive.truth[b];
  return Log(truth.linear().transpose() * (pose_a.inverse() * pose_b).linear()).norm() /
         core::kRadFromDeg;
}

TEST(PoseRefiner, StepsBetweenFramesBecomeTheOnesThePicturesShow) {
  const Drive& drive = TheDrive();
  PoseRefiner refiner({.window = 9}, {{&drive.camera, drive.body_from_camera}});
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    const RigPicture picture{0, drive.frames[i].view()};
    ASSERT_TRUE(refiner.Add(drive.priors[i], {&picture, 1}));
  }
  EXPECT_EQ(refiner.end(), drive.frames.size());
  EXPECT_EQ(refiner.first(), drive.frames.size() - 9);
  for (std::size_t i = refiner.first(); i + 2 < refiner.end(); ++i) {
    EXPECT_LT(TurnError(drive, i, i + 2, refiner.pose(i), refiner.pose(i + 2)), 0.05);
    const double length =
        (refiner.pose(i + 2).translation() - refiner.pose(i).translation()).norm();
    const double truth = (drive.truth[i + 2].translation() - drive.truth[i].translation()).norm();
    const StepDoubt doubt = refiner.Doubt(i, i + 2);
    EXPECT_LT(std::abs(length / truth - 1.0), 4.0 * doubt.length_relative_sd);
    EXPECT_LT(doubt.length_relative_sd, 0.02);
    EXPECT_LT(doubt.turn_sd_rad, 0.05 * core::kRadFromDeg);
  }
}

/// The robot's own body in the picture: tiles below a rim, the same in every frame.
StereoLab::Frame WithBody(StereoLab::Frame frame) {
  const double middle = 0.5 * (frame.width_px - 1);
  for (int v = 0; v < frame.height_px; ++v) {
    for (int u = 0; u < frame.width_px; ++u) {
      if (std::hypot(u - middle, v - middle) < 0.37 * frame.width_px) continue;
      const std::uint8_t level = (u / 9 + v / 9) % 2 == 0 ? 210 : 60;
      const auto pixel = (static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.width_px) +
                          static_cast<std::size_t>(u)) *
                         3;
      for (std::size_t c = 0; c < 3; ++c) frame.rgb[pixel + c] = level;
    }
  }
  return frame;
}

TEST(PoseRefiner, TheRobotsOwnBodySaysNothing) {
  const Drive& drive = TheDrive();
  PoseRefiner refiner({.window = 9}, {{&drive.camera, drive.body_from_camera}});
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    const StereoLab::Frame frame = WithBody(drive.frames[i]);
    const RigPicture picture{0, frame.view()};
    ASSERT_TRUE(refiner.Add(drive.priors[i], {&picture, 1}));
  }
  for (std::size_t i = refiner.first(); i + 2 < refiner.end(); ++i) {
    // Twice as much as with the whole picture: a third of it is gone. Believing the body: 1.6.
    EXPECT_LT(TurnError(drive, i, i + 2, refiner.pose(i), refiner.pose(i + 2)), 0.1);
  }
}

TEST(PoseRefiner, FramesWithoutPicturesKeepTheirPriors) {
  const Drive& drive = TheDrive();
  PoseRefiner refiner({}, {{&drive.camera, drive.body_from_camera}});
  for (std::size_t i = 0; i < 4; ++i) ASSERT_TRUE(refiner.Add(drive.priors[i], {}));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((refiner.pose(i).translation() - drive.priors[i].map_from_body.translation()).norm(),
              1e-6);
  }
}

TEST(PoseRefiner, FromTheSamePlaceIsAnErrorAndChangesNothing) {
  const Drive& drive = TheDrive();
  PoseRefiner refiner({}, {{&drive.camera, drive.body_from_camera}});
  const RigPicture picture{0, drive.frames[0].view()};
  ASSERT_TRUE(refiner.Add(drive.priors[0], {&picture, 1}));
  const auto again = refiner.Add(drive.priors[0], {&picture, 1});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_EQ(refiner.end(), 1U);
}

TEST(PoseRefiner, TheSameFramesGiveTheSameBits) {
  const Drive& drive = TheDrive();
  const auto run = [&] {
    PoseRefiner refiner({}, {{&drive.camera, drive.body_from_camera}});
    for (std::size_t i = 0; i < 5; ++i) {
      const RigPicture picture{0, drive.frames[i].view()};
      EXPECT_TRUE(refiner.Add(drive.priors[i], {&picture, 1}));
    }
    return refiner.pose(3).matrix();
  };
  EXPECT_EQ(run(), run());
}

StereoView ViewOf(const Drive& drive, std::size_t i, const StereoLab::Frame& frame) {
  return {&drive.camera, frame.view(), drive.truth[i] * drive.body_from_camera};
}

/// Those within a pixel of where the lab's geometry has them.
std::size_t CountGood(const Drive& drive, const std::vector<TrackedCorner>& corners,
                      double px_per_rad) {
  const Eigen::Isometry3d step = (drive.truth[1] * drive.body_from_camera).inverse() *
                                 (drive.truth[0] * drive.body_from_camera);
  std::size_t good = 0;
  for (const TrackedCorner& corner : corners) {
    const auto pixel = drive.model->Project(corner.ray_a);
    if (!pixel) continue;
    const auto u = static_cast<int>(std::lround(pixel->x())),
               v = static_cast<int>(std::lround(pixel->y()));
    const double range = static_cast<double>(
        drive.frames[0].range_m[static_cast<std::size_t>(v) *
                                    static_cast<std::size_t>(drive.frames[0].width_px) +
                                static_cast<std::size_t>(u)]);
    const Eigen::Vector3d expected = (step * (range * corner.ray_a)).normalized();
    good += expected.cross(corner.ray_b).norm() * px_per_rad < 1.0 ? 1U : 0U;
  }
  return good;
}

TEST(CornerTracker, FollowedRaysMeetTheTruePoints) {
  const Drive& drive = TheDrive();
  CornerTracker tracker({});
  const auto view = [&](std::size_t i) { return ViewOf(drive, i, drive.frames[i]); };
  const auto corners = tracker.Track(view(0), view(1), {});
  ASSERT_TRUE(corners);
  EXPECT_GT(corners->size(), 100U);
  for (const TrackedCorner& corner : *corners) EXPECT_EQ(corner.known, -1);
  EXPECT_GT(static_cast<double>(CountGood(drive, *corners, tracker.px_per_rad())),
            0.93 * static_cast<double>(corners->size()));
  // What was known comes back under its number.
  std::vector<Eigen::Vector3d> known;
  for (const TrackedCorner& corner : *corners) known.push_back(corner.ray_b);
  const auto further = tracker.Track(view(1), view(2), known);
  ASSERT_TRUE(further);
  std::size_t kept = 0;
  for (const TrackedCorner& corner : *further) {
    if (corner.known < 0) continue;
    ++kept;
    EXPECT_EQ(corner.ray_a, known[static_cast<std::size_t>(corner.known)]);
  }
  EXPECT_GT(kept, known.size() / 2);
}

TEST(CornerTracker, ADarkerOrBrighterPictureLosesNothing) {
  const Drive& drive = TheDrive();
  CornerTracker tracker({});
  const auto first = ViewOf(drive, 0, drive.frames[0]);
  const auto plain = tracker.Track(first, ViewOf(drive, 1, drive.frames[1]), {});
  ASSERT_TRUE(plain);
  for (const double exposure : {0.6, 1.2}) {
    SCOPED_TRACE(exposure);
    StereoLab::Frame other = drive.frames[1];
    for (std::uint8_t& level : other.rgb) {
      level = static_cast<std::uint8_t>(std::min(255.0, exposure * level + 0.5));
    }
    const auto corners = tracker.Track(first, ViewOf(drive, 1, other), {});
    ASSERT_TRUE(corners);
    EXPECT_GT(static_cast<double>(corners->size()), 0.9 * static_cast<double>(plain->size()));
    EXPECT_GT(static_cast<double>(CountGood(drive, *corners, tracker.px_per_rad())),
              0.93 * static_cast<double>(corners->size()));
  }
}

}  // namespace
}  // namespace kawara::vision
