#include "vision/remap_table.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstring>
#include <memory>

#include "vision/camera/equirectangular_camera.hpp"
#include "vision_test_support.hpp"

namespace kawara::vision {
namespace {

const Eigen::Matrix3d kNoTurn = Eigen::Matrix3d::Identity();

EquirectangularCamera Panorama(int width_px, int height_px) {
  return *EquirectangularCamera::Create(PanoramaGeometry::Full(width_px, height_px));
}

struct Remapping {
  std::string name;
  std::unique_ptr<CameraModel> source, target;
  Eigen::Matrix3d R_source_target;
};

std::vector<Remapping> Remappings() {
  std::vector<Remapping> all;
  const auto add = [&](std::string name, auto source, auto target, Eigen::Matrix3d R = kNoTurn) {
    all.push_back({std::move(name), std::make_unique<decltype(source)>(source),
                   std::make_unique<decltype(target)>(target), R});
  };
  const DoughnutCamera ring = *DoughnutCamera::Create(TestDoughnut(160));
  const EquirectangularCamera band =
      *EquirectangularCamera::Create(PanoramaGeometry::Band(454, ring.Elevations()));
  const EquirectangularCamera small =
      *EquirectangularCamera::Create(PanoramaGeometry::Band(130, ring.Elevations()));
  add("ring to panorama", ring, band);
  add("ring to small panorama: several samples a pixel", ring, small);
  add("ring to panorama, turned", ring, band, core::RotationNedFromBody({0.1, -0.2, 0.7}));
  add("panorama to ring", Panorama(300, 150), ring);
  add("panorama to itself: every last pixel", Panorama(66, 33), Panorama(66, 33));
  add("panorama enlarged", Panorama(64, 32), Panorama(201, 100));
  add("panorama reduced 5 times", Panorama(640, 320), Panorama(128, 64));
  return all;
}

// The same samples in double precision, straight from the camera models: what the table and kernel
// approximate.
double Reference(const Remapping& s, const RemapTable& table, const ConstImageView& source, int u,
                 int v, int channel) {
  const auto& run = table.run(u / RemapTable::kRunPixels, v);
  if (run.samples_u == 0) return 0.0;
  double sum = 0.0;
  for (int sv = 0; sv < run.samples_v; ++sv) {
    for (int su = 0; su < run.samples_u; ++su) {
      const auto ray = s.target->Unproject(
          {u + (su + 0.5) / run.samples_u - 0.5, v + (sv + 0.5) / run.samples_v - 0.5});
      const auto pixel = ray ? s.source->Project(s.R_source_target * *ray) : std::nullopt;
      if (!pixel) continue;
      const double x = std::clamp(pixel->x(), 0.0, source.width_px - 1.0);
      const double y = std::clamp(pixel->y(), 0.0, source.height_px - 1.0);
      const int x0 = std::min(static_cast<int>(x), source.width_px - 2);
      const int y0 = std::min(static_cast<int>(y), source.height_px - 2);
      const double fx = x - x0, fy = y - y0;
      const auto level = [&](int dx, int dy) {
        return static_cast<double>(source.row(y0 + dy)[3 * (x0 + dx) + channel]);
      };
      sum += (1 - fy) * ((1 - fx) * level(0, 0) + fx * level(1, 0)) +
             fy * ((1 - fx) * level(0, 1) + fx * level(1, 1));
    }
  }
  return sum / (run.samples_u * run.samples_v);
}

TEST(RemapTable, IsWithinOneLevelOfTheDoubleComputation) {
  for (const Remapping& s : Remappings()) {
    const auto table = RemapTable::Build(*s.source, *s.target, s.R_source_target);
    ASSERT_TRUE(table);
    const TestImage source = NoiseImage(s.source->width_px(), s.source->height_px(), 1);
    TestImage target(s.target->width_px(), s.target->height_px());
    table->Apply(source.view(), target.view());
    double worst = 0.0;
    for (int v = 0; v < target.height; ++v) {
      for (int u = 0; u < target.width; ++u) {
        for (int c = 0; c < 3; ++c) {
          worst = std::max(
              worst, std::abs(target.at(u, v)[c] - Reference(s, *table, source.view(), u, v, c)));
        }
      }
    }
    EXPECT_LT(worst, 0.55) << s.name;  // half a level is the rounding itself
    // Noise must exercise it; only a picture mapped to itself has nothing to interpolate.
    if (s.name.find("itself") == std::string::npos) {
      EXPECT_GT(worst, 0.2) << s.name;
    }
  }
}

// Highway's switch for tests; put back at the end.
struct OnlyTarget {
  explicit OnlyTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
  ~OnlyTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

TEST(RemapTable, EverySimdTargetGivesTheSameBytes) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  ASSERT_GE(targets.size(), 2u);
  for (const Remapping& s : Remappings()) {
    const auto table = RemapTable::Build(*s.source, *s.target, s.R_source_target);
    const TestImage source = NoiseImage(s.source->width_px(), s.source->height_px(), 2);
    TestImage expected(s.target->width_px(), s.target->height_px());
    table->Apply(source.view(), expected.view());
    for (std::int64_t simd : targets) {
      const OnlyTarget only(simd);
      TestImage target(s.target->width_px(), s.target->height_px());
      table->Apply(source.view(), target.view());
      EXPECT_EQ(target.bytes, expected.bytes) << s.name << " on " << hwy::TargetName(simd);
    }
  }
}

TEST(RemapTable, ThreadsDoNotChangeTheBytes) {
  for (const Remapping& s : Remappings()) {
    const auto table = RemapTable::Build(*s.source, *s.target, s.R_source_target);
    const TestImage source = NoiseImage(s.source->width_px(), s.source->height_px(), 3);
    TestImage one(s.target->width_px(), s.target->height_px()), three = one;
    table->Apply(source.view(), one.view(), 1);
    table->Apply(source.view(), three.view(), 3);
    EXPECT_EQ(one.bytes, three.bytes) << s.name;
  }
}

// A source at the very end of an allocation: the address sanitizer sees one byte too many.
TEST(RemapTable, ReadsAndWritesNothingBeyondThePictures) {
  for (const Remapping& s : Remappings()) {
    const auto table = RemapTable::Build(*s.source, *s.target, s.R_source_target);
    const TestImage noise = NoiseImage(s.source->width_px(), s.source->height_px(), 4);
    const auto exact = std::make_unique<std::uint8_t[]>(noise.bytes.size());
    std::memcpy(exact.get(), noise.bytes.data(), noise.bytes.size());
    TestImage guarded(s.target->width_px(), s.target->height_px() + 2);
    guarded.Fill(77, 77, 77);
    const ImageView inner{guarded.view().row(1), s.target->width_px(), s.target->height_px()};
    table->Apply({exact.get(), noise.width, noise.height}, inner);
    for (int u = 0; u < guarded.width; ++u) {
      ASSERT_EQ(guarded.at(u, 0)[2], 77) << s.name;
      ASSERT_EQ(guarded.at(u, guarded.height - 1)[0], 77) << s.name;
    }
  }
}

TEST(RemapTable, AConstantPictureStaysConstant) {
  for (const Remapping& s : Remappings()) {
    const auto table = RemapTable::Build(*s.source, *s.target, s.R_source_target);
    TestImage source(s.source->width_px(), s.source->height_px());
    source.Fill(255, 1, 128);
    TestImage target(s.target->width_px(), s.target->height_px());
    table->Apply(source.view(), target.view());
    for (int v = 2; v < target.height - 2; ++v) {
      for (int u = 2; u < target.width - 2; ++u) {
        const auto ray = s.target->Unproject({u, v});
        const auto pixel = ray ? s.source->Project(s.R_source_target * *ray) : std::nullopt;
        // Away from the rim, where samples outside are black by contract.
        const auto seen = [](const CameraModel& camera, const Eigen::Vector2d& at,
                             double reach_px) {
          return camera.Unproject(at + Eigen::Vector2d(reach_px, 0)) &&
                 camera.Unproject(at - Eigen::Vector2d(reach_px, 0)) &&
                 camera.Unproject(at + Eigen::Vector2d(0, reach_px)) &&
                 camera.Unproject(at - Eigen::Vector2d(0, reach_px));
        };
        const bool inside =
            pixel && seen(*s.source, *pixel, 6) && seen(*s.target, Eigen::Vector2d(u, v), 1);
        if (!inside) continue;
        ASSERT_EQ(target.at(u, v)[0], 255) << s.name << " " << u << " " << v;
        ASSERT_EQ(target.at(u, v)[1], 1) << s.name;
        ASSERT_EQ(target.at(u, v)[2], 128) << s.name;
      }
    }
  }
}

TEST(RemapTable, OutsideTheRingIsBlack) {
  DoughnutParameters p = TestDoughnut(160);
  const DoughnutCamera ring = *DoughnutCamera::Create(p);
  const EquirectangularCamera sphere = Panorama(512, 256);
  const auto table = RemapTable::Build(ring, sphere, kNoTurn);
  TestImage source(160, 160), target(512, 256);
  source.Fill(200, 200, 200);
  target.Fill(9, 9, 9);
  table->Apply(source.view(), target.view());
  for (int u = 0; u < 512; ++u) {
    EXPECT_EQ(target.at(u, 0)[0], 0);
    EXPECT_EQ(target.at(u, 255)[1], 0);
    EXPECT_EQ(target.at(u, 128)[2], 200);  // horizon
  }
}

// Stripes finer than the target's pixels must come out grey, not as moire.
TEST(RemapTable, ADenserSourceIsAveraged) {
  TestImage source(1600, 800);
  for (int v = 0; v < source.height; ++v) {
    for (int u = 0; u < source.width; ++u) {
      const std::uint8_t level = u % 2 == 0 ? 0 : 200;
      std::memset(source.at(u, v), level, 3);
    }
  }
  const auto table = RemapTable::Build(Panorama(1600, 800), Panorama(375, 188), kNoTurn);
  TestImage target(375, 188);
  table->Apply(source.view(), target.view());
  double mean = 0.0, square = 0.0;
  for (int u = 0; u < target.width; ++u) {
    mean += target.at(u, 90)[0];
    square += target.at(u, 90)[0] * target.at(u, 90)[0];
  }
  mean /= target.width;
  const double sd = std::sqrt(square / target.width - mean * mean);
  EXPECT_NEAR(mean, 100.0, 3.0);
  EXPECT_LT(sd, 30.0);  // picking single pixels gives 100, single bilinear samples 58
}

// One colour of an RGB picture as a plane in memory that ends with its last sample: the address
// sanitizer sees one byte too many.
struct ExactPlane {
  ExactPlane(const TestImage& image, int colour)
      : size(PlaneStrideBytes(image.width) * static_cast<std::size_t>(image.height - 1) +
             static_cast<std::size_t>(image.width)),
        bytes(new std::uint8_t[size]()),
        view{bytes.get(), image.width, image.height} {
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u)
        bytes[static_cast<std::size_t>(view.row(v) - view.data + u)] = image.at(u, v)[colour];
    }
  }
  std::size_t size;
  std::unique_ptr<std::uint8_t[]> bytes;
  ConstPlaneView view;
};

// What holds for RGB (the tests above) so holds for planes.
TEST(RemapTable, APlaneIsRemappedAsAColourOfRgbOnEverySimdTarget) {
  for (const Remapping& s : Remappings()) {
    const auto rgb_table = RemapTable::Build(*s.source, *s.target, s.R_source_target);
    const auto table =
        RemapTable::Build(*s.source, *s.target, s.R_source_target, 4, RemapFormat::kPlane);
    ASSERT_TRUE(table);
    const TestImage source = NoiseImage(s.source->width_px(), s.source->height_px(), 5);
    TestImage expected(s.target->width_px(), s.target->height_px());
    rgb_table->Apply(source.view(), expected.view());
    for (std::int64_t simd : hwy::SupportedAndGeneratedTargets()) {
      const OnlyTarget only(simd);
      for (int colour = 0; colour < kRgbBytes; ++colour) {
        const ExactPlane plane(source, colour), wanted(expected, colour);
        ExactPlane target(expected, colour);
        std::fill_n(target.bytes.get(), target.size, std::uint8_t{77});
        for (int threads : {1, 3}) {
          table->Apply(plane.view, {target.bytes.get(), expected.width, expected.height}, 0,
                       threads);
          for (int v = 0; v < expected.height; ++v) {
            const std::uint8_t* const row = target.view.row(v);
            ASSERT_TRUE(std::equal(row, row + expected.width, wanted.view.row(v)))
                << s.name << ", row " << v << " on " << hwy::TargetName(simd);
            if (v + 1 < expected.height) {
              ASSERT_EQ(row[expected.width], 77) << s.name;  // margin
            }
          }
        }
      }
    }
  }
}

// Chroma's black is 128: a grey source must stay grey, at the rim and beyond.
TEST(RemapTable, WhatAPlaneDoesNotSeeIsItsBlack) {
  for (const Remapping& s : Remappings()) {
    const auto table =
        RemapTable::Build(*s.source, *s.target, s.R_source_target, 4, RemapFormat::kPlane);
    TestImage grey(s.source->width_px(), s.source->height_px());
    grey.Fill(kBlackChroma, 0, 0);
    const ExactPlane source(grey, 0);
    const TestImage empty(s.target->width_px(), s.target->height_px());
    ExactPlane target(empty, 0);
    table->Apply(source.view, {target.bytes.get(), empty.width, empty.height}, kBlackChroma);
    for (int v = 0; v < empty.height; ++v) {
      for (int u = 0; u < empty.width; ++u)
        ASSERT_EQ(target.view.row(v)[u], kBlackChroma) << s.name << " at " << u << ", " << v;
    }
  }
}

TEST(RemapTable, PanoramaToRingAndBackKeepsThePicture) {
  const DoughnutCamera ring = *DoughnutCamera::Create(TestDoughnut(1024));
  const EquirectangularCamera band = *EquirectangularCamera::Create(
      PanoramaGeometry::Band(1024, {-45 * core::kRadFromDeg, 25 * core::kRadFromDeg}));
  const TestImage original = WaveImage(band.width_px(), band.height_px());
  TestImage doughnut(1024, 1024), back(band.width_px(), band.height_px());
  RemapTable::Build(band, ring, kNoTurn)->Apply(original.view(), doughnut.view());
  RemapTable::Build(ring, band, kNoTurn)->Apply(doughnut.view(), back.view());
  const int margin = 4;  // the band's rim is half black in the ring
  const ConstImageView a{original.view().row(margin), original.width, original.height - 2 * margin};
  const ConstImageView b{back.view().row(margin), back.width, back.height - 2 * margin};
  EXPECT_GT(Psnr(a, b), 38.0);
}

TEST(RemapTable, RefusesPicturesThatCannotBe) {
  EXPECT_FALSE(RemapTable::Build(Panorama(1, 1), Panorama(64, 32), kNoTurn));
  EXPECT_TRUE(RemapTable::Build(Panorama(2, 2), Panorama(1, 1), kNoTurn));
}

}  // namespace
}  // namespace kawara::vision
