#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "sim/render/renderer.hpp"
#include "tests/unit/sim_render/test_scenes.hpp"

namespace kawara::sim {
namespace {

TEST(Threads, SeveralMayRenderWithOneRendererAtOnce) {
  CameraSettings settings;
  settings.threads = 1;  // each of the threads here works alone
  const Renderer renderer(Lit(CornerScene()), Ring(96), settings, SurveyRobotBody());
  const auto render = [&](double speed_mps) {
    RenderRequest request;
    request.exposure_s = 0.02;
    request.enu_from_camera = [speed_mps](double t) {
      return UprightCamera({speed_mps * t, 0.0, 1.4}, 0.5 * t);
    };
    return renderer.Render(request);
  };
  std::vector<RenderedFrame> alone, together(4);
  for (int i = 0; i < 4; ++i) alone.push_back(render(i));
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] { together[static_cast<std::size_t>(i)] = render(i); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(alone[i].rgb, together[i].rgb) << i;
    EXPECT_EQ(alone[i].object, together[i].object) << i;
  }
  EXPECT_NE(alone[0].rgb, alone[3].rgb);
}

}  // namespace
}  // namespace kawara::sim
