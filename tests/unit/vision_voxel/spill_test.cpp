#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/test_folder.hpp"
#include "tests/unit/vision_voxel/voxel_test_support.hpp"
#include "vision/voxel/spill_codec.hpp"
#include "vision/voxel/spill_file.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {
namespace {

using testing::TestFolder;
namespace fs = std::filesystem;

constexpr VoxelMapConfig kConfig{.voxel_m = 0.1, .max_range_m = 5.0};

// There and back along the street: every tile is left and seen again.
std::vector<double> ThereAndBack() { return {0, 1, 8, 16, 24, 30, 24.5, 16.5, 8.5, 0.5}; }

void Add(VoxelMap& map, StreetDrive& drive, double x_m) {
  const auto look = drive.Look(x_m);
  ASSERT_TRUE(map.Vote(drive.ViewOf(look)));
  ASSERT_TRUE(map.Examine(drive.ViewOf(look)));
}

std::vector<std::uint8_t> BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Write(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

TEST(Spill, ThereAndBackEqualsNeverSpilled) {
  TestFolder folder;
  StreetDrive one, two;
  auto kept = VoxelMap::Create(kConfig);
  auto spilled = VoxelMap::Open(kConfig, folder / "spill");
  ASSERT_TRUE(spilled) << spilled.error().message;
  std::size_t most = 0;
  for (const double x : ThereAndBack()) {
    Add(*kept, one, x);
    Add(*spilled, two, x);
    ASSERT_TRUE(spilled->SpillBeyond({x, 0, 0}, 6.0));
    most = std::max(most, spilled->memory_bytes());
  }
  EXPECT_GT(spilled->counts().tiles_spilled, 10U);
  EXPECT_GT(spilled->counts().tiles_returned, 5U);
  EXPECT_LT(most, kept->memory_bytes() * 7 / 10);
  EXPECT_EQ(spilled->Tiles(), kept->Tiles());
  EXPECT_TRUE(SameContents(ContentsOf(*spilled), ContentsOf(*kept)));
}

TEST(Spill, AfterAKillItGoesOnFromTheCommitAsIfNothingHadBeen) {
  TestFolder folder;
  StreetDrive one;
  auto whole = VoxelMap::Create(kConfig);
  for (const double x : ThereAndBack()) Add(*whole, one, x);
  // Killed: committed after four pictures, three more voted and partly spilled, then gone.
  const auto path = ThereAndBack();
  StreetDrive two;
  std::vector<testing::BoxWorldView> looks;
  for (const double x : path) looks.push_back(two.Look(x));
  const auto add = [&](VoxelMap& map, std::size_t i) {
    ASSERT_TRUE(map.Vote(two.ViewOf(looks[i])));
    ASSERT_TRUE(map.Examine(two.ViewOf(looks[i])));
    ASSERT_TRUE(map.SpillBeyond({path[i], 0, 0}, 6.0));
  };
  {
    auto killed = VoxelMap::Open(kConfig, folder / "spill");
    for (std::size_t i = 0; i < 4; ++i) add(*killed, i);
    ASSERT_TRUE(killed->Commit(4));
    for (std::size_t i = 4; i < 7; ++i) add(*killed, i);
  }
  auto resumed = VoxelMap::Open(kConfig, folder / "spill");
  ASSERT_TRUE(resumed) << resumed.error().message;
  EXPECT_EQ(resumed->progress(), 4U);
  for (std::size_t i = resumed->progress(); i < path.size(); ++i) add(*resumed, i);
  EXPECT_TRUE(SameContents(ContentsOf(*resumed), ContentsOf(*whole)));
  EXPECT_EQ(resumed->damaged_records(), 0U);
}

TEST(Spill, ATornTailIsForgotten) {
  TestFolder folder;
  StreetDrive drive(0.002, 128);
  const std::string path = folder / "spill";
  {
    auto map = VoxelMap::Open(kConfig, path);
    Add(*map, drive, 0.0);
    ASSERT_TRUE(map->Commit(1));
  }
  const auto committed = BytesOf(path);
  {
    auto map = VoxelMap::Open(kConfig, path);
    Add(*map, drive, 30.0);
    ASSERT_TRUE(map->Commit(2));
  }
  const auto both = BytesOf(path);
  ASSERT_GT(both.size(), committed.size() + 1000);
  for (const std::size_t cut :
       {committed.size(), committed.size() + 1, committed.size() + 500, both.size() - 1}) {
    Write(path, {both.begin(), both.begin() + static_cast<std::ptrdiff_t>(cut)});
    const auto map = VoxelMap::Open(kConfig, path);
    ASSERT_TRUE(map) << map.error().message;
    EXPECT_EQ(map->progress(), 1U) << cut;
    EXPECT_EQ(fs::file_size(path), committed.size()) << cut;
  }
}

TEST(Spill, EveryDamagedByteIsNoticed) {
  TestFolder folder;
  const std::string path = folder / "spill";
  {
    auto file = SpillFile::Open(path, 0.1);
    ASSERT_TRUE(file);
    for (std::int32_t i = 0; i < 3; ++i)
      ASSERT_TRUE(file->Append({i, -i}, std::vector<std::uint8_t>(40, std::uint8_t(i + 1))));
    ASSERT_TRUE(file->Commit(7, 8));
  }
  const auto good = BytesOf(path);
  for (std::size_t at = 0; at < good.size(); ++at) {
    auto bad = good;
    bad[at] ^= 0x10;
    const auto contents = ScanSpill(bad);
    const bool noticed = !contents || contents->damaged_records > 0 || contents->progress != 7;
    EXPECT_TRUE(noticed) << "byte " << at;
    if (!contents) continue;
    // And what was not hit is still there, unless it was the commit.
    if (contents->progress == 7) {
      EXPECT_EQ(contents->tiles.size(), 2U) << at;
    }
  }
}

TEST(Spill, DamageUnderARunningMapIsAnErrorNotAWrongMap) {
  TestFolder folder;
  StreetDrive drive(0.002, 128);
  const std::string path = folder / "spill";
  auto map = VoxelMap::Open(kConfig, path);
  Add(*map, drive, 0.0);
  ASSERT_TRUE(map->SpillBeyond({100, 0, 0}, 6.0));
  auto bytes = BytesOf(path);
  for (std::size_t at = 200; at < bytes.size(); at += 200) bytes[at] ^= 1;
  Write(path, bytes);
  const auto look = drive.Look(0.0);
  const auto voted = map->Vote(drive.ViewOf(look));
  ASSERT_FALSE(voted);
  EXPECT_EQ(voted.error().code, core::ErrorCode::kFormat);
  EXPECT_NE(voted.error().message.find(path), std::string::npos);
}

TEST(Spill, AFileOfOtherVoxelsOrOfSomebodyElseIsRefused) {
  TestFolder folder;
  ASSERT_TRUE(SpillFile::Open(folder / "spill", 0.1));
  EXPECT_TRUE(SpillFile::Open(folder / "spill", 0.1));
  EXPECT_FALSE(SpillFile::Open(folder / "spill", 0.2));
  std::ofstream(folder / "text") << "this is somebody's diary and not a spill file";
  const auto opened = SpillFile::Open(folder / "text", 0.1);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, core::ErrorCode::kFormat);
  EXPECT_EQ(BytesOf(folder / "text").size(), 45U);  // and left alone
}

TEST(Spill, ReplacedRecordsAreCompactedAway) {
  TestFolder folder;
  auto file = SpillFile::Open(folder / "spill", 0.1);
  const std::vector<std::uint8_t> megabytes(std::size_t{3} << 20, 5);
  for (std::uint64_t i = 1; i <= 30; ++i) {
    for (std::int32_t t = 0; t < 2; ++t) {
      std::vector<std::uint8_t> payload = megabytes;
      payload[0] = static_cast<std::uint8_t>(i);
      ASSERT_TRUE(file->Append({t, 0}, payload));
    }
    ASSERT_TRUE(file->Commit(i, i));
    EXPECT_LT(file->bytes(), std::uint64_t{80} << 20);
  }
  auto again = SpillFile::Open(folder / "spill", 0.1);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->contents().progress, 30U);
  EXPECT_EQ(again->Read({1, 0})->at(0), 30);
}

TEST(SpillCodec, RoundTripAndEveryCutRefused) {
  StreetDrive drive(0.002, 128);
  BlockGrid grid;
  VoxelBlock& block = grid.FindOrMake({7, 8, -3});
  block.revision = 99;
  for (const std::size_t i : {511U, 63U, 64U, 0U, 7U}) {
    const std::uint16_t slot = grid.AddVoxel(block, i);
    Voxel& v = block.voxels[slot - 1];
    v.weight = 10.0F + static_cast<float>(i);
    v.moment = {1.0F, -2.0F, 3.0F};
    v.hits = 5;
    v.colour = {100, 200, 300};
    v.to_viewer = {-8191, 3, 4};
  }
  const TileIndex tile{0, 1};
  const auto bytes = EncodeTile(grid.tiles().at(tile));
  TileDecoder decoder(bytes, tile);
  SpilledBlock back;
  ASSERT_TRUE(*decoder.Next(back));
  EXPECT_EQ(back.index, block.index);
  EXPECT_EQ(back.revision, 99U);
  ASSERT_EQ(back.size, 5U);
  for (std::size_t i = 0; i < back.size; ++i)
    EXPECT_TRUE(SameBytes(back.voxels[i], block.voxels[block.slot[back.places[i]] - 1]));
  EXPECT_FALSE(*decoder.Next(back));

  for (std::size_t size = 0; size < bytes.size(); ++size) {
    TileDecoder cut({bytes.data(), size}, tile);
    core::Expected<bool> more = true;
    while (more && *more) more = cut.Next(back);
    EXPECT_FALSE(more) << size;
  }
  TileDecoder elsewhere(bytes, {1, 1});
  EXPECT_FALSE(elsewhere.Next(back));
}

}  // namespace
}  // namespace kawara::vision
