#include "vision/stereo/paper_matcher.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "tests/support/stereo_lab.hpp"
#include "vision/camera/camera_choice.hpp"
#include "vision/camera/doughnut_camera.hpp"

namespace kawara::vision {
namespace {

using test_support::StereoLab;
constexpr int kSizePx = 320;

/// The method of the paper written from its equations, for reading and not for speed, in double
/// precision and by the camera's own Project.
class PlainPaperMethod {
 public:
  struct View {
    const CameraModel* camera;
    const StereoLab::Frame* picture;
    const StereoCamera* seen;  ///< for its mask only
    Eigen::Isometry3d map_from_camera;
  };
  struct Answer {
    double disparity_rad = 0.0;
    double rad_per_px = 0.0;
    double range_m = 0.0;
  };

  PlainPaperMethod(const View& a, const View& b, double knot_rad)
      : a_(a),
        b_(b),
        knot_rad_(knot_rad),
        b_from_a_(b.map_from_camera.inverse() * a.map_from_camera) {
    for (int i = -5; i <= 5; ++i) {
      for (int j = -5; j <= 5; ++j)
        taps_.push_back({i, j, std::exp(-0.5 * (i * i + j * j) / 2.75 / 2.75)});
    }
  }

  /// An edge with room for its window.
  static bool Candidate(const View& view, int u, int v) {
    return Edge(view, u, v) && Room(view, u, v);
  }

  std::optional<Answer> Match(int u, int v) const {
    const auto at = a_.camera->Unproject({u, v});          // eqs. (1) to (3)
    const Eigen::Vector3d ray = b_from_a_.linear() * *at;  // eq. (6)
    // Eqs. (4), (5), (7), (8): the plane of the ray, and of the way back to A.
    const Eigen::Vector3d to_a = b_from_a_.translation();
    const double base_m = to_a.norm();
    const double cosine = ray.dot(-to_a) / base_m, sine = std::sqrt(1.0 - cosine * cosine);
    if (sine < 1e-4) return {};
    const Eigen::Vector3d away = (cosine * ray + to_a / base_m) / sine;
    const auto along_curve = [&](double delta) {
      return (std::cos(delta) * ray + std::sin(delta) * away).eval();
    };
    const double widest = std::atan2(base_m * sine, kNearest - base_m * cosine);

    struct Step {
      double delta;
      Eigen::Vector2d pixel;
      bool visible;
    };
    std::vector<Step> steps;
    double next = 0.0;
    bool running = false, past = false;
    for (int k = 0; k < static_cast<int>(widest / knot_rad_) + 1 && !past; ++k) {
      const auto p = b_.camera->Project(along_curve(k * knot_rad_));
      const auto q = b_.camera->Project(along_curve((k + 1) * knot_rad_));
      if (!p || !q) {
        if (running) steps.push_back({0.0, {}, false});
        running = false;
        next = 0.0;
        continue;
      }
      running = true;
      const double length = (*q - *p).norm();
      for (; next < length; next += 1.0) {
        const double t = next / length, delta = (k + t) * knot_rad_;
        past = past || delta > widest;
        if (!past) steps.push_back({delta, *p + t * (*q - *p), true});
      }
      next -= length;
    }

    const Eigen::Vector3d up(1, 0, 0);
    const auto window = Window(a_, {u, v}, *at, up);
    const auto cost = [&](const Step& step) {
      return Cost(window, Window(b_, step.pixel, along_curve(step.delta), b_from_a_.linear() * up));
    };
    const auto room = [&](const Step& step) {
      return step.visible && step.pixel.minCoeff() >= 0 &&
             Room(b_, Floor(step.pixel.x()), Floor(step.pixel.y()));
    };
    std::optional<std::size_t> best;
    double least = 0.0;
    for (std::size_t s = 0; s < steps.size(); ++s) {
      if (!room(steps[s])) continue;
      const int iu = Floor(steps[s].pixel.x()), iv = Floor(steps[s].pixel.y());
      if (!Edge(b_, iu, iv) && !Edge(b_, iu + 1, iv) && !Edge(b_, iu, iv + 1) &&
          !Edge(b_, iu + 1, iv + 1))
        continue;
      const double sum = cost(steps[s]);
      if (best && sum >= least) continue;
      best = s;  // eq. (12)
      least = sum;
    }
    if (!best || *best == 0 || *best + 1 >= steps.size()) return {};
    const Step &before = steps[*best - 1], &after = steps[*best + 1];
    if (!room(before) || !room(after)) return {};
    const double left = cost(before), right = cost(after), bend = left - 2 * least + right;
    const double offset = bend > 0 ? std::clamp(0.5 * (left - right) / bend, -1.0, 1.0) : 0.0;
    Answer answer;
    answer.rad_per_px = 0.5 * (after.delta - before.delta);
    answer.disparity_rad = steps[*best].delta + offset * answer.rad_per_px;
    if (answer.disparity_rad <= 0) return {};
    // Sine rule in the triangle of the viewpoints and the point.
    answer.range_m = base_m * std::sin(std::acos(cosine) + answer.disparity_rad) /
                     std::sin(answer.disparity_rad);
    return answer;
  }

 private:
  struct Tap {
    int along, across;
    double weight;
  };
  using Levels = std::vector<Eigen::Vector3d>;
  static constexpr double kNearest = 1.5;

  static int Floor(double x) { return static_cast<int>(std::floor(x)); }
  static double Level(const View& view, int u, int v, int channel) {
    return view.picture
        ->rgb[static_cast<std::size_t>((v * view.picture->width_px + u) * 3 + channel)];
  }
  static bool Seen(const View& view, int u, int v) {
    if (u < 0 || v < 0 || u >= view.picture->width_px || v >= view.picture->height_px) return false;
    return view.seen->rays().seen(static_cast<std::size_t>(v * view.picture->width_px + u));
  }
  static bool Room(const View& view, int u, int v) {
    for (int i = -9; i <= 9; ++i) {
      for (int j = -9; j <= 9; ++j) {
        if (!Seen(view, u + i, v + j)) return false;
      }
    }
    return true;
  }
  static bool Edge(const View& view, int u, int v) {
    if (u < 1 || v < 1 || u + 1 >= view.picture->width_px || v + 1 >= view.picture->height_px)
      return false;
    for (int c = 0; c < 3; ++c) {
      double gx = 0, gy = 0;
      for (int k = -1; k <= 1; ++k) {
        const double weight = k == 0 ? 2 : 1;
        const auto level = [&](int du, int dv) {
          // What is not seen is black.
          return Seen(view, u + du, v + dv) ? Level(view, u + du, v + dv, c) : 0.0;
        };
        gx += weight * (level(1, k) - level(-1, k));
        gy += weight * (level(k, 1) - level(k, -1));
      }
      if (std::abs(gx) + std::abs(gy) >= 80) return true;
    }
    return false;
  }
  Levels Window(const View& view, const Eigen::Vector2d& centre, const Eigen::Vector3d& ray,
                const Eigen::Vector3d& up) const {
    // Where the picture moves when the ray turns up: in a ring, along its azimuth.
    const auto above = view.camera->Project(ray + 1e-4 * up),
               below = view.camera->Project(ray - 1e-4 * up);
    const Eigen::Vector2d along = (*above - *below).normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    Levels levels;
    for (const Tap& tap : taps_) {
      const Eigen::Vector2d p = centre + tap.along * along + tap.across * across;
      const int u = Floor(p.x()), v = Floor(p.y());
      const double s = p.x() - u, t = p.y() - v;
      Eigen::Vector3d level;
      for (int c = 0; c < 3; ++c) {
        level[c] = (1 - t) * ((1 - s) * Level(view, u, v, c) + s * Level(view, u + 1, v, c)) +
                   t * ((1 - s) * Level(view, u, v + 1, c) + s * Level(view, u + 1, v + 1, c));
      }
      levels.push_back(level);
    }
    return levels;
  }
  double Cost(const Levels& base, const Levels& reference) const {
    double sum = 0;
    for (std::size_t k = 0; k < taps_.size(); ++k) {
      const double e = (base[k] - reference[k]).cwiseAbs().maxCoeff();  // eqs. (9), (10)
      sum += taps_[k].weight * e * e;                                   // eq. (11)
    }
    return sum;
  }

  View a_, b_;
  double knot_rad_;
  Eigen::Isometry3d b_from_a_;
  std::vector<Tap> taps_;
};

Eigen::Isometry3d Pose(double along_m, double turn_rad) {
  Eigen::Matrix3d map_from_frd;
  map_from_frd << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(along_m, 0.02 * turn_rad, 2.0);
  pose.linear() = map_from_frd *
                  Eigen::AngleAxisd(turn_rad, Eigen::Vector3d(0.1, 0.2, 1.0).normalized()) *
                  BodyFromCamera();
  return pose;
}

std::shared_ptr<const CameraModel> Ring() {
  return std::make_shared<DoughnutCamera>(
      *DoughnutCamera::Create(DoughnutParameters{}.Resized(kSizePx, kSizePx)));
}

/// Looks ahead, 170 deg wide.
std::shared_ptr<const CameraModel> Fisheye() {
  CameraChoice choice;
  choice.camera = "kb4";
  auto& lens = choice.kb4;
  lens.common.width_px = lens.common.height_px = kSizePx;
  lens.common.center_u_px = lens.common.center_v_px = 0.5 * (kSizePx - 1);
  lens.common.max_angle_deg = 85.0;
  lens.focal.fx_px = lens.focal.fy_px = 110.0;
  lens.k = {0.02, -0.005, 0.0, 0.0};
  return *MakeCamera(choice);
}

std::shared_ptr<const CameraModel> Sphere() {
  CameraChoice choice;
  choice.camera = "equirectangular";
  choice.equirectangular.width_px = 2 * kSizePx;
  choice.equirectangular.height_px = kSizePx;
  return *MakeCamera(choice);
}

struct Scene {
  std::shared_ptr<const CameraModel> model;
  std::shared_ptr<const StereoCamera> camera;
  StereoLab::Frame a, b;
  Eigen::Isometry3d pose_a, pose_b;

  explicit Scene(std::shared_ptr<const CameraModel> lens)
      : model(std::move(lens)),
        camera(std::make_shared<StereoCamera>(model)),
        pose_a(Pose(-0.25, 0.03)),
        pose_b(Pose(0.25, -0.05)) {
    test_support::StereoLabOptions options;
    options.samples = 2;
    const StereoLab lab(options);
    a = lab.Render(*model, pose_a, 1);
    b = lab.Render(*model, pose_b, 2);
  }
  StereoView view_a() const { return {camera.get(), a.view(), pose_a}; }
  StereoView view_b() const { return {camera.get(), b.view(), pose_b}; }
};

struct Comparison {
  double candidates = 0, known = 0, same = 0, apart = 0;
};

/// Of every `every`th candidate: same when both say unknown, or disparities within 0.1 px.
Comparison Compare(const Scene& scene, const PaperMatcher& matcher, const RangeImage& ranges,
                   int every) {
  const PlainPaperMethod::View a{scene.model.get(), &scene.a, scene.camera.get(), scene.pose_a};
  const PlainPaperMethod::View b{scene.model.get(), &scene.b, scene.camera.get(), scene.pose_b};
  const PlainPaperMethod plain(a, b, EpipolarCurve::KnotSpacing(*scene.camera));
  const EpipolarPair pair = *EpipolarPair::FromPoses(scene.pose_a, scene.pose_b);
  Comparison result;
  int number = 0;
  for (int v = 0; v < ranges.height_px; ++v) {
    for (int u = 0; u < ranges.width_px; ++u) {
      const std::size_t i = ranges.index(u, v);
      const bool candidate = PlainPaperMethod::Candidate(a, u, v);
      EXPECT_EQ(matcher.candidate(i), candidate) << u << " " << v;
      if (!candidate) {
        EXPECT_TRUE(std::isnan(ranges.range_m[i]));
        continue;
      }
      if (++number % every != 0) continue;
      result.candidates += 1;
      const auto answer = plain.Match(u, v);
      const bool known = !std::isnan(ranges.range_m[i]);
      if (known) result.known += 1;
      if (!answer || !known) {
        (answer.has_value() == known ? result.same : result.apart) += 1;
        continue;
      }
      const double alpha =
          std::acos((pair.a_from_epipolar.transpose() * *scene.model->Unproject({u, v})).x());
      const double disparity = pair.Disparity(alpha, static_cast<double>(ranges.range_m[i]));
      const bool same = std::abs(disparity - answer->disparity_rad) < 0.1 * answer->rad_per_px;
      (same ? result.same : result.apart) += 1;
    }
  }
  return result;
}

struct Errors {
  double median_m = 0.0, outliers = 0.0, known = 0.0, within_2_sd = 0.0;
};

/// Of the candidates between 2 and 6 m, 25 deg from the baseline. Median and honesty of those
/// within 10 %.
Errors Judge(const Scene& scene, const PaperMatcher& matcher, const RangeImage& ranges) {
  const Eigen::Vector3d baseline =
      scene.pose_a.linear().transpose() *
      (scene.pose_b.translation() - scene.pose_a.translation()).normalized();
  std::vector<double> errors;
  double wanted = 0, known = 0, honest = 0;
  for (int v = 0; v < ranges.height_px; ++v) {
    for (int u = 0; u < ranges.width_px; ++u) {
      const std::size_t i = ranges.index(u, v);
      const double truth = static_cast<double>(scene.a.range_m[i]);
      if (!matcher.candidate(i) || !(truth >= 2.0 && truth <= 6.0)) continue;
      if (std::abs(scene.model->Unproject({u, v})->dot(baseline)) >
          std::cos(25.0 * core::kRadFromDeg))
        continue;
      wanted += 1;
      if (std::isnan(ranges.range_m[i])) continue;
      known += 1;
      const double error = std::abs(static_cast<double>(ranges.range_m[i]) - truth);
      if (error > 0.1 * truth) continue;
      errors.push_back(error);
      if (error < 2.0 * static_cast<double>(ranges.sd_m[i])) honest += 1;
    }
  }
  std::sort(errors.begin(), errors.end());
  const auto near = static_cast<double>(errors.size());
  return {errors[errors.size() / 2], 1.0 - near / known, known / wanted, honest / near};
}

class PaperMatcherTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { scene_ = new Scene(Ring()); }
  static void TearDownTestSuite() { delete scene_; }
  static inline const Scene* scene_ = nullptr;
};

TEST_F(PaperMatcherTest, IsTheMethodAsPlainlyWritten) {
  PaperMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), ranges));
  const Comparison result = Compare(*scene_, matcher, ranges, 3);
  RecordProperty("candidates", std::to_string(result.candidates));
  RecordProperty("apart", std::to_string(result.apart));
  EXPECT_GT(result.candidates, 1000);
  EXPECT_GT(result.known, 0.9 * result.candidates);
  EXPECT_LT(result.apart, 0.005 * result.candidates);
}

TEST_F(PaperMatcherTest, RangesOfASceneAreRightAndSoAreTheirDeviations) {
  PaperMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), ranges));
  const Errors errors = Judge(*scene_, matcher, ranges);
  EXPECT_LT(errors.median_m, 0.06);
  EXPECT_LT(errors.outliers, 0.20);
  EXPECT_GT(errors.known, 0.95);
  EXPECT_GT(errors.within_2_sd, 0.80);
}

TEST_F(PaperMatcherTest, EveryProcessorFindsTheSame) {
  PaperMatcher matcher({});
  RangeImage best;
  ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), best));
  const std::int64_t supported = hwy::SupportedTargets();
  for (std::int64_t left = supported & HWY_TARGETS; left != 0; left &= left - 1) {
    hwy::GetChosenTarget().Update(left & -left);
    RangeImage ranges;
    ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), ranges));
    double known = 0, same = 0;
    for (std::size_t i = 0; i < best.range_m.size(); ++i) {
      if (std::isnan(best.range_m[i])) continue;
      known += 1;
      // Only sums of products are rounded otherwise without fused ones.
      if (std::abs(ranges.range_m[i] - best.range_m[i]) < 1e-2F * best.range_m[i]) same += 1;
    }
    EXPECT_GT(same, 0.999 * known) << hwy::TargetName(left & -left);
  }
  hwy::GetChosenTarget().Update(supported);
}

TEST_F(PaperMatcherTest, TheRobotsOwnBodyIsNotMeasured) {
  std::vector<std::uint8_t> mask(scene_->a.range_m.size(), 255);
  const auto hidden = [](int u, int v) { return u >= 40 && u < 120 && v >= 150 && v < 200; };
  for (int v = 0; v < kSizePx; ++v) {
    for (int u = 0; u < kSizePx; ++u) {
      if (hidden(u, v)) mask[static_cast<std::size_t>(kSizePx * v + u)] = 0;
    }
  }
  const StereoCamera masked(scene_->model, mask);
  PaperMatcher matcher({});
  RangeImage ranges, unmasked;
  ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), unmasked));
  ASSERT_TRUE(matcher.Match({&masked, scene_->a.view(), scene_->pose_a},
                            {&masked, scene_->b.view(), scene_->pose_b}, ranges));
  int there = 0;
  for (int v = 0; v < kSizePx; ++v) {
    for (int u = 0; u < kSizePx; ++u) {
      // Nor is anything measured with a window that the mask cuts.
      if (!hidden(u + 5, v) && !hidden(u - 5, v) && !hidden(u, v)) continue;
      EXPECT_TRUE(std::isnan(ranges.range_m[ranges.index(u, v)])) << u << " " << v;
      if (!std::isnan(unmasked.range_m[ranges.index(u, v)])) ++there;
    }
  }
  EXPECT_GT(there, 50);
}

TEST_F(PaperMatcherTest, TheSameTwiceIsTheSameBytes) {
  PaperMatcher matcher({});
  RangeImage first, second;
  ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), first));
  ASSERT_TRUE(matcher.Match(scene_->view_b(), scene_->view_a(), second));
  ASSERT_TRUE(matcher.Match(scene_->view_a(), scene_->view_b(), second));
  EXPECT_EQ(std::memcmp(first.range_m.data(), second.range_m.data(), 4 * first.range_m.size()), 0);
  EXPECT_EQ(std::memcmp(first.sd_m.data(), second.sd_m.data(), 4 * first.sd_m.size()), 0);
}

TEST_F(PaperMatcherTest, NoBaselineIsAnError) {
  PaperMatcher matcher({});
  RangeImage ranges;
  EXPECT_FALSE(matcher.Match(scene_->view_a(),
                             {scene_->camera.get(), scene_->b.view(), scene_->pose_a}, ranges));
}

TEST_F(PaperMatcherTest, AGreyPictureIsAsGood) {
  Scene grey(*scene_);
  for (StereoLab::Frame* frame : {&grey.a, &grey.b}) {
    for (std::size_t i = 0; i < frame->rgb.size(); i += 3) {
      const int sum = frame->rgb[i] + frame->rgb[i + 1] + frame->rgb[i + 2];
      for (std::size_t c = 0; c < 3; ++c) frame->rgb[i + c] = static_cast<std::uint8_t>(sum / 3);
    }
  }
  PaperMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match(grey.view_a(), grey.view_b(), ranges));
  const Errors errors = Judge(grey, matcher, ranges);
  EXPECT_LT(errors.median_m, 0.08);
  EXPECT_LT(errors.outliers, 0.25);
  EXPECT_GT(errors.known, 0.9);
}

// Its windows turn with "up" and not about the picture's centre, which lies ahead.
TEST(PaperMatcher, AFisheyeThatLooksAheadIsMatchedAsPlainlyWritten) {
  const Scene scene(Fisheye());
  ASSERT_TRUE(scene.camera->projection());
  PaperMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match(scene.view_a(), scene.view_b(), ranges));
  const Comparison result = Compare(scene, matcher, ranges, 5);
  EXPECT_GT(result.candidates, 500);
  EXPECT_LT(result.apart, 0.01 * result.candidates);
  const Errors errors = Judge(scene, matcher, ranges);
  EXPECT_LT(errors.median_m, 0.08);
  EXPECT_LT(errors.outliers, 0.25);
}

TEST(PaperMatcher, ACameraWithoutARadialTableIsMatchedAsPlainlyWritten) {
  const Scene scene(Sphere());
  ASSERT_FALSE(scene.camera->projection());
  PaperMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match(scene.view_a(), scene.view_b(), ranges));
  const Comparison result = Compare(scene, matcher, ranges, 17);
  EXPECT_GT(result.candidates, 500);
  EXPECT_LT(result.apart, 0.01 * result.candidates);
}

// A's windows are in its own pixels, B's are as large on the sphere.
TEST(PaperMatcher, TwoDifferentCamerasMakeAPair) {
  const Scene ring(Ring());
  auto parameters = DoughnutParameters{}.Resized(kSizePx * 5 / 4, kSizePx * 5 / 4);
  parameters.mirrored = true;
  const Scene larger(std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(parameters)));
  PaperMatcher matcher({});
  RangeImage ranges;
  ASSERT_TRUE(matcher.Match(ring.view_a(), larger.view_b(), ranges));
  const Errors errors = Judge(ring, matcher, ranges);
  EXPECT_LT(errors.median_m, 0.07);
  EXPECT_LT(errors.outliers, 0.25);
  EXPECT_GT(errors.known, 0.9);
}

}  // namespace
}  // namespace kawara::vision
