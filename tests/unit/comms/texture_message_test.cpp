#include "comms/texture_message.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "comms/codec.hpp"

namespace kawara::comms {
namespace {

TextureReport Report(std::size_t bytes, std::uint64_t revision = 3) {
  TextureReport report{"rover", "20261123T100000Z", "rover-1", revision, {}};
  report.textures.atlas_jpeg.resize(bytes);
  std::mt19937 dice(static_cast<std::uint32_t>(bytes));
  for (auto& byte : report.textures.atlas_jpeg) byte = static_cast<std::uint8_t>(dice());
  report.textures.width_px = 512;
  report.textures.height_px = 256;
  for (const auto side : {core::BoxSide::kLeft, core::BoxSide::kRear}) {
    core::FaceTexture face;
    face.side = side;
    face.corners_px = {{{0.5, 1.5}, {200.0, 1.5}, {200.0, 120.25}, {0.5, 120.25}}};
    face.source = "20261123T100000Z/17";
    face.taken = core::UtcTime::FromNs(1'790'000'000'123'456'789);
    face.seen_share = 0.75;
    report.textures.faces.push_back(face);
  }
  return report;
}

TextureReport Expect(const core::Expected<std::optional<TextureReport>>& added) {
  EXPECT_TRUE(added) << added.error().message;
  EXPECT_TRUE(*added);
  return added && *added ? **added : TextureReport{};
}

TEST(TextureMessage, PartsInAnyOrderWithRepeatsMakeTheAtlas) {
  const TextureReport sent = Report(30'123);
  const auto parts = ToMessages(sent);
  ASSERT_TRUE(parts) << parts.error().message;
  std::vector<std::size_t> order(parts->size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  TextureAssembler assembler;
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    const auto bytes = Encode((*parts)[order[i]]);
    ASSERT_TRUE(bytes);
    EXPECT_LT(bytes->size(), 1400U);
    for (int twice = 0; twice < 2; ++twice) {
      const auto added = assembler.Add(*Decode<object_texture_t>(*bytes));
      ASSERT_TRUE(added) << added.error().message;
      EXPECT_FALSE(*added);
    }
  }
  const TextureReport back = Expect(assembler.Add((*parts)[order.back()]));
  EXPECT_EQ(back.robot, sent.robot);
  EXPECT_EQ(back.uid, sent.uid);
  EXPECT_EQ(back.revision, sent.revision);
  EXPECT_EQ(back.textures.atlas_jpeg, sent.textures.atlas_jpeg);
  EXPECT_EQ(back.textures.width_px, 512U);
  EXPECT_EQ(back.textures.height_px, 256U);
  ASSERT_EQ(back.textures.faces.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const core::FaceTexture &a = sent.textures.faces[i], &b = back.textures.faces[i];
    EXPECT_EQ(a.side, b.side);
    EXPECT_EQ(a.corners_px, b.corners_px);
    EXPECT_EQ(a.source, b.source);
    EXPECT_EQ(a.taken, b.taken);
    EXPECT_EQ(a.seen_share, b.seen_share);
  }
}

TEST(TextureMessage, RevisionsDoNotMixAndOldOnesAreGivenUp) {
  TextureAssembler assembler;
  const auto first = *ToMessages(Report(2000, 1)), second = *ToMessages(Report(2000, 2));
  ASSERT_EQ(first.size(), 3U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_FALSE(*assembler.Add(first[i]));
    EXPECT_FALSE(*assembler.Add(second[i]));
  }
  EXPECT_EQ(Expect(assembler.Add(second[2])).revision, 2U);
  EXPECT_EQ(Expect(assembler.Add(first[2])).revision, 1U);
  for (std::uint64_t r = 1; r <= TextureAssembler::kMostOpen + 5; ++r)
    EXPECT_FALSE(*assembler.Add(ToMessages(Report(2000, r))->front()));
  EXPECT_EQ(assembler.given_up(), 5U);
}

TEST(TextureMessage, AnAtlasMadeAnewReplacesTheHalfOfTheOldOne) {
  TextureAssembler assembler;
  const auto old = *ToMessages(Report(2500)), fresh = *ToMessages(Report(1500));
  EXPECT_FALSE(*assembler.Add(old[0]));
  EXPECT_FALSE(*assembler.Add(fresh[0]));
  EXPECT_EQ(Expect(assembler.Add(fresh[1])).textures.atlas_jpeg, Report(1500).textures.atlas_jpeg);
}

TEST(TextureMessage, HostilePartsAreRefused) {
  const auto refused = [](const auto& spoil) {
    object_texture_t m = ToMessages(Report(2000))->front();
    spoil(m);
    TextureAssembler assembler;
    const auto added = assembler.Add(m);
    return !added && added.error().code == core::ErrorCode::kFormat;
  };
  using M = object_texture_t;
  EXPECT_FALSE(refused([](M&) {}));
  EXPECT_TRUE(refused([](M& m) { m.uid.clear(); }));
  EXPECT_TRUE(refused([](M& m) { m.revision = 0; }));
  EXPECT_TRUE(refused([](M& m) { m.part = 3; }));
  EXPECT_TRUE(refused([](M& m) { m.part = -1; }));
  EXPECT_TRUE(refused([](M& m) { m.parts = 1 << 30; }));
  EXPECT_TRUE(refused([](M& m) { m.atlas_bytes = 1 << 30; }));
  EXPECT_TRUE(refused([](M& m) { m.atlas_bytes = 0; }));
  EXPECT_TRUE(refused([](M& m) { m.width_px = 0; }));
  EXPECT_TRUE(refused([](M& m) { m.side[0] = 7; }));
  EXPECT_TRUE(refused([](M& m) { m.corners_px[0][0] = -1.0F; }));
  EXPECT_TRUE(refused([](M& m) { m.corners_px[0][2] = std::nanf(""); }));
  EXPECT_TRUE(refused([](M& m) { m.seen_share[1] = 2.0F; }));
  EXPECT_TRUE(refused([](M& m) { m.jpeg.pop_back(); }));
}

TEST(TextureMessage, NoAtlasOrTooLargeAOneIsNotSent) {
  EXPECT_FALSE(ToMessages(Report(0)));
  EXPECT_FALSE(ToMessages(Report(TextureAssembler::kMaxAtlasBytes + 1)));
  EXPECT_TRUE(ToMessages(Report(TextureAssembler::kMaxAtlasBytes)));
}

}  // namespace
}  // namespace kawara::comms
