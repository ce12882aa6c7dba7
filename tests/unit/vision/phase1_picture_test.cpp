#include "vision/phase1_picture.hpp"

#include <gtest/gtest.h>

#include "tests/support/counting_allocator.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/panorama_metadata.hpp"
#include "vision_test_support.hpp"

namespace kawara::vision {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes Encoded(const TestImage& image, bool progressive = false) {
  JpegEncoder encoder;
  const auto jpeg = encoder.Encode(image.view(), {.quality = 92, .progressive = progressive});
  return {jpeg->begin(), jpeg->end()};
}

SourceFrame JpegFrame(const Bytes& jpeg) { return {SourceFrame::Format::kJpeg, 0, 0, jpeg}; }

Phase1PictureConfig Doughnut() {
  Phase1PictureConfig config;
  config.doughnut = TestDoughnut(400);
  config.panorama.width_px = 720;
  config.preview_width_px = 180;
  return config;
}

Phase1PictureConfig PassThrough() {
  Phase1PictureConfig config;
  config.camera = "equirectangular";
  config.preview_width_px = 512;
  return config;
}

TEST(Phase1Picture, DoughnutGivesPreviewAndPanoramaOfTheSameScene) {
  auto job = Phase1Picture::Create(Doughnut());
  ASSERT_TRUE(job) << job.error().message;
  const TestImage ring = WaveImage(400, 400);
  const Bytes jpeg = Encoded(ring);
  const SourceFrame raw{SourceFrame::Format::kRgb8, 400, 400, ring.bytes};
  JpegDecoder decoder;
  for (const SourceFrame& frame : {JpegFrame(jpeg), raw}) {
    const auto preview = job->Preview(frame);
    ASSERT_TRUE(preview) << preview.error().message;
    EXPECT_EQ(preview->geometry, (PanoramaGeometry{180, 40, 180, 90, 0, 30}));
    const TestImage small(*decoder.Decode(preview->jpeg));
    const auto full = job->Full(frame);
    ASSERT_TRUE(full) << full.error().message;
    EXPECT_EQ(full->geometry, (PanoramaGeometry{720, 160, 720, 360, 0, 120}));
    EXPECT_LT(preview->jpeg.size(), full->jpeg.size() / 4);
    EXPECT_TRUE(full->original.empty());
    const TestImage reduced(*decoder.Decode(full->jpeg, {.scale_eighths = 2}));
    ASSERT_EQ(reduced.width, small.width);
    EXPECT_GT(Psnr(reduced.view(), small.view()), 20.0);  // another scene, or a shifted one: 8
  }
}

// A real street seen through the mirror.
TestImage RealRing(const DoughnutParameters& doughnut) {
  JpegDecoder decoder;
  const auto panorama =
      decoder.Decode(ReadTestFile("data/panorama/R0014760_3072.jpg"), {.scale_eighths = 4});
  TestImage ring(doughnut.width_px, doughnut.height_px);
  RemapTable::Build(*EquirectangularCamera::Create(
                        PanoramaGeometry::Full(panorama->width_px, panorama->height_px)),
                    *DoughnutCamera::Create(doughnut), Eigen::Matrix3d::Identity())
      ->Apply(*panorama, ring.view());
  return ring;
}

// The picture by way of RGB: decoded, unwrapped and encoded in full colour resolution.
TestImage FullByRgb(const Phase1PictureConfig& config, const Bytes& jpeg,
                    const core::Attitude& attitude) {
  auto unwrapper = PanoramaUnwrapper::Create(
      std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(config.doughnut)), config.panorama);
  EXPECT_TRUE(unwrapper->SetAttitude(attitude));
  TestImage panorama(unwrapper->geometry().width_px, unwrapper->geometry().height_px);
  JpegDecoder decoder;
  unwrapper->Unwrap(*decoder.Decode(jpeg), panorama.view());
  return panorama;
}

// Colours may differ by what the resolution of 4:2:0 chroma leaves open: 0.7 % of the range (43 dB)
// over the picture, nothing on the mean. A chroma half a pixel beside its place fails with the
// waves.
TEST(Phase1Picture, PlanesGiveThePictureThatRgbGives) {
  struct Case {
    const char* name;
    void (*change)(Phase1PictureConfig&);
  };
  const Case cases[] = {
      {"as it is", [](Phase1PictureConfig&) {}},
      {"odd height, odd rows above",
       [](Phase1PictureConfig& c) {
         c.panorama.width_px = 734;
         c.panorama.elevation_top_deg = 21.1;
         c.panorama.elevation_bottom_deg = -37.0;
       }},
      {"more than the camera sees",
       [](Phase1PictureConfig& c) {
         c.panorama.elevation_top_deg = 60;
         c.panorama.elevation_bottom_deg = -70;
       }},
      {"odd ring",
       [](Phase1PictureConfig& c) {
         c.doughnut.width_px = 511;
         c.doughnut.height_px = 509;
       }},
      {"level and north up",
       [](Phase1PictureConfig& c) { c.panorama.level = c.panorama.north_up = true; }},
  };
  const core::Attitude attitude{0.08, -0.06, 1.9};
  for (const Case& c : cases) {
    Phase1PictureConfig config;
    config.doughnut = TestDoughnut(512);
    config.panorama.width_px = 750;
    config.quality = 97;  // so that the encoder has no say
    c.change(config);
    auto job = Phase1Picture::Create(config);
    ASSERT_TRUE(job) << job.error().message;
    ASSERT_TRUE(job->SetAttitude(attitude));
    for (const TestImage& ring : {RealRing(config.doughnut),
                                  WaveImage(config.doughnut.width_px, config.doughnut.height_px)}) {
      const Bytes frame = Encoded(ring);
      const auto full = job->Full(JpegFrame(frame));
      ASSERT_TRUE(full) << full.error().message;
      JpegDecoder decoder;
      const auto ours = decoder.DecodeYuv420(full->jpeg);
      const TestImage by_rgb = FullByRgb(config, frame, attitude);
      ASSERT_EQ(ours->width_px(), by_rgb.width);
      ASSERT_EQ(ours->height_px(), by_rgb.height);
      Yuv420Buffer buffer;
      const Yuv420View expected = buffer.View(by_rgb.width, by_rgb.height);
      Yuv420FromRgb(by_rgb.view(), expected);
      for (const auto& [plane, wanted] :
           {std::pair{ours->y, expected.y}, {ours->cb, expected.cb}, {ours->cr, expected.cr}}) {
        EXPECT_GT(PlanePsnr(plane, wanted), 43.0) << c.name;
        EXPECT_NEAR(PlaneMean(plane), PlaneMean(wanted), 0.2) << c.name;
      }
    }
  }
}

TEST(Phase1Picture, UncompressedFramesGiveThePictureOfCompressedOnes) {
  Phase1PictureConfig config;
  config.doughnut = TestDoughnut(512);
  config.panorama.width_px = 750;
  auto job = Phase1Picture::Create(config);
  const TestImage ring = RealRing(config.doughnut);
  const Bytes jpeg = Encoded(ring);
  JpegDecoder decoder;
  const TestImage from_jpeg(*decoder.Decode(job->Full(JpegFrame(jpeg))->jpeg));
  const TestImage from_rgb(
      *decoder.Decode(job->Full({SourceFrame::Format::kRgb8, 512, 512, ring.bytes})->jpeg));
  EXPECT_GT(Psnr(from_jpeg.view(), from_rgb.view()), 35.0);
}

// Preview and full picture share one decoding; nobody may be able to tell.
TEST(Phase1Picture, WhatWasMadeBeforeDoesNotShow) {
  auto job = Phase1Picture::Create(Doughnut());
  const auto copy = [](const core::Expected<EncodedPicture>& p) {
    return Bytes(p->jpeg.begin(), p->jpeg.end());
  };
  const Bytes first = Encoded(WaveImage(400, 400)), second = Encoded(NoiseImage(400, 400, 2));
  const Bytes preview = copy(job->Preview(JpegFrame(first))),
              full = copy(job->Full(JpegFrame(first)));
  ASSERT_TRUE(job->Preview(JpegFrame(second)));
  EXPECT_EQ(copy(job->Full(JpegFrame(first))), full);
  EXPECT_EQ(copy(job->Preview(JpegFrame(first))), preview);
  // Another picture in the same memory, of the same length.
  Bytes memory = first;
  memory.resize(std::max(first.size(), second.size()));
  ASSERT_EQ(copy(job->Preview(JpegFrame(memory))), preview);
  std::copy(second.begin(), second.end(), memory.begin());
  EXPECT_NE(copy(job->Full(JpegFrame(memory))), full);
  // A frame that fails must not leave the one before it in its place.
  EXPECT_FALSE(job->Preview(JpegFrame(Bytes(100, 1))));
  EXPECT_FALSE(job->Full(JpegFrame(Bytes(100, 1))));
}

TEST(Phase1Picture, AllocatesNothingAfterTheFirstFrame) {
  auto job = Phase1Picture::Create(Doughnut());
  const Bytes large = Encoded(NoiseImage(400, 400, 3)), small = Encoded(WaveImage(400, 400));
  (void)job->Preview(JpegFrame(large));
  (void)job->Full(JpegFrame(large));
  EXPECT_EQ(testing::CountAllocations([&] {
              (void)job->Preview(JpegFrame(small));
              (void)job->Full(JpegFrame(small));
            }),
            0U);
}

TEST(Phase1Picture, SameFrameSameBytes) {
  auto one = Phase1Picture::Create(Doughnut()), two = Phase1Picture::Create(Doughnut());
  const Bytes jpeg = Encoded(WaveImage(400, 400)), other = Encoded(NoiseImage(400, 400, 1));
  (void)two->Preview(JpegFrame(other));
  (void)two->Full(JpegFrame(other));
  const auto copy = [](const core::Expected<EncodedPicture>& p) {
    return Bytes(p->jpeg.begin(), p->jpeg.end());
  };
  EXPECT_EQ(copy(one->Preview(JpegFrame(jpeg))), copy(two->Preview(JpegFrame(jpeg))));
  EXPECT_EQ(copy(one->Full(JpegFrame(jpeg))), copy(two->Full(JpegFrame(jpeg))));
}

TEST(Phase1Picture, PreviewStaysValidWhileTheFullPictureIsMade) {
  auto job = Phase1Picture::Create(Doughnut());
  const Bytes jpeg = Encoded(WaveImage(400, 400));
  const auto preview = job->Preview(JpegFrame(jpeg));
  const Bytes before(preview->jpeg.begin(), preview->jpeg.end());
  ASSERT_TRUE(job->Full(JpegFrame(jpeg)));
  EXPECT_TRUE(std::equal(before.begin(), before.end(), preview->jpeg.begin(), preview->jpeg.end()));
}

TEST(Phase1Picture, PassThroughSendsTheCamerasOwnBytes) {
  auto job = Phase1Picture::Create(PassThrough());
  ASSERT_TRUE(job);
  const Bytes camera = ReadTestFile("data/panorama/R0014760_3072.jpg");
  const auto full = job->Full(JpegFrame(camera));
  ASSERT_TRUE(full);
  EXPECT_EQ(full->jpeg.data(), camera.data());
  EXPECT_EQ(full->jpeg.size(), camera.size());
  EXPECT_EQ(full->geometry, PanoramaGeometry::Full(3072, 1536));
  const auto preview = job->Preview(JpegFrame(camera));
  ASSERT_TRUE(preview);
  EXPECT_EQ(preview->geometry, PanoramaGeometry::Full(512, 256));
  EXPECT_LT(preview->jpeg.size(), 40'000u);
}

TEST(Phase1Picture, PassThroughReducesToTheLimitAndKeepsTheCamerasTags) {
  Phase1PictureConfig config = PassThrough();
  config.max_width_px = 1000;
  auto job = Phase1Picture::Create(config);
  const Bytes camera = ReadTestFile("data/panorama/R0014760_3072.jpg");
  const auto full = job->Full(JpegFrame(camera));
  ASSERT_TRUE(full) << full.error().message;
  EXPECT_EQ(full->geometry, PanoramaGeometry::Full(1000, 500));
  JpegDecoder decoder;
  const auto picture = decoder.Decode(full->jpeg);
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width_px, 1000);
  EXPECT_EQ(picture->height_px, 500);
  PanoramaMetadata metadata;
  metadata.geometry = full->geometry;
  Bytes tagged;
  ASSERT_TRUE(InsertPanoramaMetadata(full->jpeg, full->original, metadata, &tagged));
  const auto back = ReadPanoramaMetadata(tagged);
  EXPECT_EQ(back->model, "RICOH THETA V");
  EXPECT_EQ(back->geometry, full->geometry);
  // The picture must be the camera's, reduced: compare with another path to the same size.
  const TestImage ours(*picture);
  const TestImage eighth(*decoder.Decode(camera, {.scale_eighths = 1}));
  auto preview_config = config;
  preview_config.preview_width_px = 384;
  auto again = Phase1Picture::Create(preview_config);
  const TestImage small(*decoder.Decode(again->Preview(JpegFrame(camera))->jpeg));
  ASSERT_EQ(small.width, eighth.width);
  EXPECT_GT(Psnr(small.view(), eighth.view()), 25.0);
}

TEST(Phase1Picture, DamagedFramesAreErrorsAndTheNextOneWorks) {
  for (const Phase1PictureConfig& config : {Doughnut(), PassThrough()}) {
    auto job = Phase1Picture::Create(config);
    const Bytes good = Encoded(WaveImage(400, 400));
    Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(good.size() / 2));
    const Bytes nonsense(5000, 0x42);
    for (const Bytes& bad : {cut, nonsense, Bytes{}}) {
      const auto preview = job->Preview(JpegFrame(bad));
      ASSERT_FALSE(preview);
      EXPECT_EQ(preview.error().code, core::ErrorCode::kFormat);
    }
    EXPECT_TRUE(job->Preview(JpegFrame(good)));
    EXPECT_TRUE(job->Full(JpegFrame(good)));
  }
}

TEST(Phase1Picture, AFrameOfAnotherSizeIsSaid) {
  auto job = Phase1Picture::Create(Doughnut());
  const Bytes other = Encoded(WaveImage(640, 480));
  const auto full = job->Full(JpegFrame(other));
  ASSERT_FALSE(full);
  EXPECT_NE(full.error().message.find("640 x 480"), std::string::npos) << full.error().message;
  EXPECT_NE(full.error().message.find("400 x 400"), std::string::npos) << full.error().message;
  const Bytes pixels(100, 0);
  EXPECT_FALSE(job->Full({SourceFrame::Format::kRgb8, 400, 400, pixels}));
}

TEST(Phase1Picture, MetadataFitsWhatWasMade) {
  auto job = Phase1Picture::Create(Doughnut());
  const Bytes jpeg = Encoded(WaveImage(400, 400));
  const auto full = job->Full(JpegFrame(jpeg));
  PanoramaMetadata metadata;
  metadata.geometry = full->geometry;
  const core::Attitude body{0.01, 0.02, 0.3};
  metadata.attitude = job->PictureAttitude(body);
  EXPECT_NEAR(metadata.attitude->yaw_rad, body.yaw_rad, 1e-12);
  Bytes tagged;
  ASSERT_TRUE(InsertPanoramaMetadata(full->jpeg, metadata, &tagged));
  EXPECT_EQ(ReadPanoramaMetadata(tagged)->geometry, full->geometry);
}

TEST(Phase1Picture, RefusesConfigurationsThatCannotBe) {
  struct Case {
    const char* key;
    void (*spoil)(Phase1PictureConfig&);
  };
  const Case cases[] = {
      {"camera", [](Phase1PictureConfig& c) { c.camera = "fisheye"; }},
      {"quality", [](Phase1PictureConfig& c) { c.quality = 101; }},
      {"preview_width_px", [](Phase1PictureConfig& c) { c.preview_width_px = 3; }},
      {"l_out_px", [](Phase1PictureConfig& c) { c.doughnut.l_out_px = 0; }},
      {"width_px", [](Phase1PictureConfig& c) { c.panorama.width_px = 101; }},
      {"max_width_px", [](Phase1PictureConfig& c) { c.max_width_px = -1; }},
      {"panorama.level",
       [](Phase1PictureConfig& c) { c.camera = "equirectangular", c.panorama.level = true; }},
  };
  for (const Case& c : cases) {
    Phase1PictureConfig config = Doughnut();
    c.spoil(config);
    const auto job = Phase1Picture::Create(config);
    ASSERT_FALSE(job) << c.key;
    EXPECT_NE(job.error().message.find(c.key), std::string::npos) << job.error().message;
  }
}

}  // namespace
}  // namespace kawara::vision
