#include "vision/yuv420.hpp"

#include <gtest/gtest.h>

#include "vision_test_support.hpp"

namespace kawara::vision {
namespace {

struct Plane {
  const char* name;
  ConstPlaneView view;
};

std::vector<Plane> Planes(const ConstYuv420View& p) {
  return {{"y", p.y}, {"cb", p.cb}, {"cr", p.cr}};
}

TEST(Yuv420, ColoursAreThoseOfJfif) {
  struct Case {
    std::uint8_t rgb[3], yuv[3];
  };
  // JFIF 1.02: Y = 0.299 R + 0.587 G + 0.114 B, Cb = 128 - 0.1687 R - 0.3313 G + 0.5 B,
  // Cr = 128 + 0.5 R - 0.4187 G - 0.0813 B, rounded and clamped.
  const Case cases[] = {{{0, 0, 0}, {0, 128, 128}},      {{255, 255, 255}, {255, 128, 128}},
                        {{77, 77, 77}, {77, 128, 128}},  {{255, 0, 0}, {76, 85, 255}},
                        {{0, 255, 0}, {150, 44, 21}},    {{0, 0, 255}, {29, 255, 107}},
                        {{200, 100, 50}, {124, 86, 182}}};
  for (const Case& c : cases) {
    TestImage image(5, 3);
    image.Fill(c.rgb[0], c.rgb[1], c.rgb[2]);
    Yuv420Buffer buffer;
    const Yuv420View yuv = buffer.View(5, 3);
    Yuv420FromRgb(image.view(), yuv);
    EXPECT_EQ(yuv.cb.width_px, 3);
    EXPECT_EQ(yuv.cb.height_px, 2);
    EXPECT_EQ(yuv.y.row(2)[4], c.yuv[0]);
    EXPECT_EQ(yuv.cb.row(1)[2], c.yuv[1]);
    EXPECT_EQ(yuv.cr.row(0)[0], c.yuv[2]);
  }
}

// Blue left and right of a chroma sample's two columns must not reach it.
TEST(Yuv420, AChromaSampleIsTheMeanOfItsFourPixels) {
  TestImage image(6, 4);
  for (const auto& [u, v] : {std::pair{2, 2}, {3, 2}, {2, 3}}) image.at(u, v)[2] = 255;
  Yuv420Buffer buffer;
  const Yuv420View yuv = buffer.View(6, 4);
  Yuv420FromRgb(image.view(), yuv);
  EXPECT_NEAR(yuv.cb.row(1)[1], 128 + 0.75 * 127.5, 1.0);
  EXPECT_EQ(yuv.cb.row(1)[0], 128);
  EXPECT_EQ(yuv.cb.row(1)[2], 128);
  EXPECT_EQ(yuv.cb.row(0)[1], 128);
}

TEST(Yuv420, TheMarginRepeatsTheEdges) {
  for (const auto& [width, height] : {std::pair{21, 11}, {16, 8}, {1, 1}, {30, 33}}) {
    const TestImage image = NoiseImage(width, height, 3);
    Yuv420Buffer buffer;
    const Yuv420View yuv = buffer.View(width, height);
    Yuv420FromRgb(image.view(), yuv);
    for (const auto& [name, plane] : Planes(yuv)) {
      for (int v = 0; v < (plane.height_px + 7) / 8 * 8; ++v) {
        for (int u = 0; u < (plane.width_px + 7) / 8 * 8; ++u) {
          ASSERT_EQ(plane.row(v)[u],
                    plane.row(std::min(v, plane.height_px - 1))[std::min(u, plane.width_px - 1)])
              << name << " " << width << " x " << height << " at " << u << ", " << v;
        }
      }
    }
  }
}

TEST(Yuv420, ReducedSamplesAreTheRoundedMeansOfTheirBlocks) {
  for (const auto& [width, height] : {std::pair{64, 48}, {61, 47}, {1, 1}, {9, 100}}) {
    const TestImage image = NoiseImage(width, height, 4);
    Yuv420Buffer buffer, small_buffer;
    const Yuv420View yuv = buffer.View(width, height);
    Yuv420FromRgb(image.view(), yuv);
    for (const int factor : {1, 2, 4, 8}) {
      const Yuv420View small =
          small_buffer.View((width + factor - 1) / factor, (height + factor - 1) / factor);
      ReduceYuv420(yuv, factor, small);
      const auto sources = Planes(yuv), targets = Planes(small);
      for (std::size_t i = 0; i < sources.size(); ++i) {
        const ConstPlaneView& from = sources[i].view;
        const ConstPlaneView& to = targets[i].view;
        for (int v = 0; v < to.height_px; ++v) {
          for (int u = 0; u < to.width_px; ++u) {
            int sum = 0;
            for (int y = 0; y < factor; ++y) {
              for (int x = 0; x < factor; ++x) sum += from.row(v * factor + y)[u * factor + x];
            }
            ASSERT_EQ(to.row(v)[u], (sum + factor * factor / 2) / (factor * factor))
                << sources[i].name << " / " << factor << " at " << u << ", " << v;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace kawara::vision
