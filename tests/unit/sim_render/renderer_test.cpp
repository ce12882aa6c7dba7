#include "sim/render/renderer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/sim_render/test_scenes.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector3d;

CameraSettings Clean() {
  CameraSettings settings;
  settings.lens.vignetting = 0.0;
  settings.lens.dirt_spots = 0;
  settings.sensor.full_well_e = 0.0;
  return settings;
}

RenderRequest From(const Vector3d& place, double heading_rad = 0.0) {
  RenderRequest request;
  request.enu_from_camera = Still(UprightCamera(place, heading_rad));
  return request;
}

double Grey(const RenderedFrame& frame, int u, int v) {
  const std::uint8_t* p = frame.view().row(v) + 3 * u;
  return (p[0] + p[1] + p[2]) / 3.0;
}

TEST(Renderer, RangeOfAPlaneIsExactForEveryPixelOfEveryCamera) {
  Scene scene;
  AddGround(scene, 2000.0, 1, AddMaterial(scene));
  const auto lit = Lit(scene);
  const Vector3d eye(11.0, -5.0, 1.4);
  for (const std::shared_ptr<const vision::CameraModel>& camera :
       {std::shared_ptr<const vision::CameraModel>(Ring(200)),
        std::shared_ptr<const vision::CameraModel>(Sphere(200))}) {
    const Eigen::Isometry3d pose = UprightCamera(eye, 0.7);
    RenderRequest request;
    request.enu_from_camera = Still(pose);
    const RenderedFrame frame = Renderer(lit, camera, Clean()).Render(request);
    int seen = 0;
    for (int v = 0; v < frame.height_px; ++v) {
      for (int u = 0; u < frame.width_px; ++u) {
        const float range = frame.range_m[static_cast<std::size_t>(v * frame.width_px + u)];
        const auto ray = camera->Unproject({static_cast<double>(u), static_cast<double>(v)});
        ASSERT_EQ(std::isnan(range), !ray.has_value()) << u << " " << v;
        if (!ray) continue;
        const double down = -(pose.linear() * *ray).z();
        const double expected = 1.4 / down;
        if (down <= 1e-6 || expected > 300.0) continue;
        ASSERT_NEAR(range, expected, 1e-3) << u << " " << v;
        ++seen;
      }
    }
    EXPECT_GT(seen, 5000);
  }
}

TEST(Renderer, RangeOfABallIsExactAwayFromItsLimb) {
  Scene scene;
  const Vector3d center(0.0, 4.0, 1.5);
  AddSphere(scene, center, 1.0, 160, 9, AddMaterial(scene));
  const auto camera = Ahead(720, 140);
  const Eigen::Isometry3d pose = UprightCamera({0, 0, 1.5}, 0.0);
  RenderRequest request;
  request.enu_from_camera = Still(pose);
  const RenderedFrame frame = Renderer(Lit(scene), camera, Clean()).Render(request);
  int seen = 0;
  for (int v = 0; v < frame.height_px; ++v) {
    for (int u = 0; u < frame.width_px; ++u) {
      const std::size_t at = static_cast<std::size_t>(v * frame.width_px + u);
      const Vector3d d =
          pose.linear() * *camera->Unproject({static_cast<double>(u), static_cast<double>(v)});
      const Vector3d to = center - pose.translation();
      const double closest = to.dot(d);
      const double inside = 1.0 - (to.squaredNorm() - closest * closest);
      if (closest < 0.0 || inside < -0.01) {
        EXPECT_EQ(frame.object[at], 0U);
        EXPECT_TRUE(std::isinf(frame.range_m[at]));
      } else if (inside > 0.05) {
        EXPECT_EQ(frame.object[at], 9U);
        EXPECT_NEAR(frame.range_m[at], closest - std::sqrt(inside), 1e-3);
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 1500);
}

TEST(Renderer, TheNumberOfThreadsChangesNoByte) {
  const auto lit = Lit(CornerScene());
  RenderRequest request = From({0, 0, 1.4});
  request.exposure_s = 0.01;
  request.readout_s = 0.02;
  request.enu_from_camera = [](double t) { return UprightCamera({0.5 * t, t, 1.4}, 0.3 * t); };
  CameraSettings settings;
  settings.threads = 1;
  const RenderedFrame alone = Renderer(lit, Ring(160), settings, SurveyRobotBody()).Render(request);
  for (const int threads : {2, 5, 0}) {
    settings.threads = threads;
    const RenderedFrame more =
        Renderer(lit, Ring(160), settings, SurveyRobotBody()).Render(request);
    EXPECT_EQ(alone.rgb, more.rgb) << threads;
    EXPECT_EQ(alone.object, more.object) << threads;
    EXPECT_EQ(0, std::memcmp(alone.range_m.data(), more.range_m.data(),
                             alone.range_m.size() * sizeof(float)))
        << threads;
  }
  request.noise_seed = 2;
  EXPECT_NE(alone.rgb, Renderer(lit, Ring(160), settings, SurveyRobotBody()).Render(request).rgb);
}

TEST(Renderer, ShadowsFallAwayFromTheSun) {
  Scene scene;
  AddGround(scene, 30.0, 1, AddMaterial(scene));
  AddBox(scene, {-1, -1, 0}, {1, 1, 4}, 2, 0);
  scene.sun.azimuth_rad = core::kPi / 2;  // in the east, 45 degrees up: 4 m of shadow to the west
  scene.sun.elevation_rad = core::kPi / 4;
  const auto lit = Lit(scene);
  CameraSettings settings = Clean();
  settings.sensor.automatic = false;
  const Renderer renderer(lit, Sphere(128), settings);
  const auto grey_below = [&](double east) {  // straight down is the last row
    return Grey(renderer.Render(From({east, 0, 1.5})), 64, 62);
  };
  EXPECT_LT(grey_below(-3.0), 0.75 * grey_below(3.0));
  EXPECT_NEAR(grey_below(-9.0), grey_below(9.0), 8.0);
}

TEST(Renderer, LightIsDimmerUnderARoofThanInTheOpen) {
  Scene scene;
  AddGround(scene, 30.0, 1, AddMaterial(scene));
  AddBox(scene, {-4, -4, 2.5}, {4, 4, 2.7}, 2, 0);
  scene.sun.elevation_rad = -0.1;  // dusk: light of the sky alone
  scene.sun.sky_share = 1.0;
  CameraSettings settings = Clean();
  settings.sensor.automatic = false;
  const Renderer renderer(Lit(scene), Sphere(128), settings);
  EXPECT_LT(Grey(renderer.Render(From({0, 0, 1.0})), 64, 62),
            0.6 * Grey(renderer.Render(From({15, 0, 1.0})), 64, 62));
}

// A tall thin pole north of the camera, seen by a camera that moves east: how wide and how inclined
// its picture is tells of exposure and shutter.
struct PoleView {
  double width_px = 0.0;
  double middle_px = 0.0;
};
double Light(const RenderedFrame& frame, int u, int row) {
  const double s = Grey(frame, u, row) / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
PoleView LookAtPole(const RenderedFrame& frame, int row) {
  const int first = frame.width_px / 2 - 40;
  const int last = frame.width_px / 2 + 40;
  const double background = 0.5 * (Light(frame, first, row) + Light(frame, last, row));
  double sum = 0.0;
  double moment = 0.0;
  for (int u = first; u < last; ++u) {
    const double dark = std::max(0.0, background - Light(frame, u, row));
    if (dark < 0.03 * background) continue;
    sum += dark;
    moment += dark * u;
  }
  const double middle = moment / sum;
  double spread = 0.0;
  for (int u = first; u < last; ++u) {
    const double dark = std::max(0.0, background - Light(frame, u, row));
    if (dark >= 0.03 * background) spread += dark * (u - middle) * (u - middle);
  }
  return {std::sqrt(12.0 * spread / sum), middle};
}

Scene PoleScene() {
  Scene scene;
  AddBox(scene, {-0.06, 5.0, -20}, {0.06, 5.02, 30}, 1,
         AddMaterial(scene, Pattern::kPlain, {0.01F, 0.01F, 0.01F}));
  AddBox(scene, {-60, 20, -40}, {60, 21, 60}, 2,
         AddMaterial(scene, Pattern::kPlain, {0.9F, 0.9F, 0.9F}));
  scene.sun.azimuth_rad = core::kPi;  // behind the camera
  return scene;
}

TEST(Renderer, MotionDuringTheExposureBlursAlongTheMotion) {
  const Renderer renderer(Lit(PoleScene()), Ahead(1440, 160), Clean());
  RenderRequest request = From({0, 0, 1.5});
  const PoleView still = LookAtPole(renderer.Render(request), 80);
  // 0.1 m at 5 m is 20 mrad or 4.6 px; standing still and moving ahead blur nothing.
  request.exposure_s = 0.1;
  EXPECT_NEAR(LookAtPole(renderer.Render(request), 80).width_px, still.width_px, 1e-9);
  request.enu_from_camera = [](double t) { return UprightCamera({0, 0.1 * t, 1.5}, 0.0); };
  EXPECT_NEAR(LookAtPole(renderer.Render(request), 80).width_px, still.width_px, 0.3);
  request.enu_from_camera = [](double t) { return UprightCamera({t, 0, 1.5}, 0.0); };
  const PoleView moved = LookAtPole(renderer.Render(request), 80);
  EXPECT_NEAR(moved.width_px, std::hypot(still.width_px, 4.58), 0.3);
  EXPECT_NEAR(moved.middle_px, still.middle_px, 0.3);  // the truth is that of mid-exposure
}

TEST(Renderer, ARollingShutterShearsWhatAGlobalOneKeepsUpright) {
  const Renderer renderer(Lit(PoleScene()), Ahead(1440, 160), Clean());
  RenderRequest request = From({0, 0, 1.5});
  request.enu_from_camera = [](double t) { return UprightCamera({t, 0, 1.5}, 0.0); };
  const RenderedFrame global = renderer.Render(request);
  EXPECT_NEAR(LookAtPole(global, 20).middle_px, LookAtPole(global, 140).middle_px, 0.2);
  request.readout_s = 0.1;
  const RenderedFrame rolling = renderer.Render(request);
  // 120 of 159 row steps are 75.5 ms or mm: the pole, 5 m off, falls back 3.46 px to the left.
  EXPECT_NEAR(LookAtPole(rolling, 20).middle_px - LookAtPole(rolling, 140).middle_px, 3.46, 0.3);
  EXPECT_NEAR(LookAtPole(rolling, 80).middle_px, LookAtPole(global, 80).middle_px, 0.2);
}

TEST(Renderer, TheBodyStandsInTheWayAndIsNamed) {
  const auto lit = Lit(CornerScene());
  const Renderer with(lit, Ring(200), Clean(), SurveyRobotBody());
  const Renderer without(lit, Ring(200), Clean());
  const RenderedFrame a = with.Render(From({0, 0, 1.2}));
  const RenderedFrame b = without.Render(From({0, 0, 1.2}));
  int body = 0;
  for (std::size_t i = 0; i < a.object.size(); ++i) {
    if (a.object[i] == kRobotBodyObject) {
      ++body;
      EXPECT_LT(a.range_m[i], 1.5F);
    } else {
      EXPECT_EQ(a.object[i], b.object[i]);
    }
  }
  EXPECT_GT(body, 100);
}

TEST(Renderer, NothingButTheRingSeesAnything) {
  const auto camera = Ring(300);
  const RenderedFrame frame =
      Renderer(Lit(CornerScene()), camera, Clean()).Render(From({0, 0, 1.4}));
  for (int v = 0; v < 300; v += 3) {
    for (int u = 0; u < 300; u += 3) {
      const bool inside =
          camera->Unproject({static_cast<double>(u), static_cast<double>(v)}).has_value();
      EXPECT_EQ(std::isnan(frame.range_m[static_cast<std::size_t>(v * 300 + u)]), !inside);
      if (!inside) {
        EXPECT_LT(Grey(frame, u, v), 60.0);
      }
    }
  }
}

TEST(Renderer, AutomaticExposureBringsTheMeanToItsTarget) {
  CameraSettings settings = Clean();
  settings.sensor.target = 0.18;
  const RenderedFrame frame =
      Renderer(Lit(CornerScene()), Ring(120), settings).Render(From({0, 0, 1.4}));
  EXPECT_NEAR(frame.gain * frame.mean_light, 0.18, 1e-6);
  settings.sensor.gain_max = 0.01;
  settings.sensor.gain_min = 0.01;
  EXPECT_DOUBLE_EQ(Renderer(Lit(CornerScene()), Ring(120), settings).Render(From({0, 0, 1.4})).gain,
                   0.01);
}

TEST(Renderer, DirtDimsWhereItSits) {
  CameraSettings dirty = Clean();
  dirty.sensor.automatic = false;
  CameraSettings clean = dirty;
  dirty.lens.dirt_spots = 8;
  const auto lit = Lit(CornerScene());
  const RenderedFrame a = Renderer(lit, Ring(200), dirty).Render(From({0, 0, 1.4}));
  const RenderedFrame b = Renderer(lit, Ring(200), clean).Render(From({0, 0, 1.4}));
  int differ = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) differ += a.rgb[i] != b.rgb[i] ? 1 : 0;
  EXPECT_GT(differ, 20);
  EXPECT_LT(differ, 40000 / 20);
}

}  // namespace
}  // namespace kawara::sim
