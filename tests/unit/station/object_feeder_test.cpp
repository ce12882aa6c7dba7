#include "station/object_feeder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "station/store_feeder.hpp"
#include "tests/unit/gis/fixture.hpp"

namespace kawara::station {
namespace {

namespace fs = std::filesystem;

core::UtcTime At(int seconds) {
  return core::UtcTime::FromNs(1'790'000'000'000'000'000) + core::Seconds(seconds);
}

comms::ObjectReport Report(std::uint64_t revision) {
  comms::ObjectReport report{"rover", "m1", {0.617, 2.435, 52.0}, {}};
  core::ChangedObject& o = report.object;
  o.uid = "rover-m1-1";
  o.revision = revision;
  o.box = {{10.0, 5.0, 1.5}, {7.0, 2.2, 3.0}, 1.6};
  o.covariance.diagonal().setConstant(0.01);
  o.existence_probability = 0.99;
  o.first_seen = At(0);
  o.last_seen = At(static_cast<int>(revision));
  o.robots = {"rover"};
  return report;
}

comms::TextureReport Texture(std::uint64_t revision) {
  comms::TextureReport report{"rover", "m1", "rover-m1-1", revision, {}};
  report.textures.atlas_jpeg = *gis::testing::Jpeg(64, 32, 500);
  report.textures.width_px = 64;
  report.textures.height_px = 32;
  core::FaceTexture face;
  face.corners_px = {{{0, 0}, {64, 0}, {64, 32}, {0, 32}}};
  report.textures.faces = {face};
  return report;
}

class ObjectFeederTest : public ::testing::Test {
 protected:
  ObjectFeederTest() {
    std::string name = (fs::temp_directory_path() / "kawara-feeder-XXXXXX").string();
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~ObjectFeederTest() override { fs::remove_all(folder_); }
  std::string store() const { return (folder_ / "store.gpkg").string(); }
  /// Newest revision in the store, with a feeder of its own.
  std::uint64_t Newest() const {
    auto objects = gis::ObjectRegister::Open(
        {.target = store(), .origin = {0.617, 2.435, 52.0}, .survey = "m1", .who = "test"});
    EXPECT_TRUE(objects);
    return *objects->LastRevision("rover-m1-1");
  }
  fs::path folder_;
};

TEST_F(ObjectFeederTest, TellsWhatIsNewAndWhatWasKnown) {
  ObjectFeeder feeder(store());
  for (const std::uint64_t revision : {1U, 2U, 1U, 2U}) ASSERT_TRUE(feeder.Add(Report(revision)));
  ASSERT_TRUE(feeder.Add(Texture(2)));
  EXPECT_EQ(feeder.counts().revisions, 2U);
  EXPECT_EQ(feeder.counts().known, 2U);
  EXPECT_EQ(feeder.counts().textures, 1U);
  ASSERT_TRUE(feeder.Close());
  EXPECT_EQ(Newest(), 2U);
}

TEST_F(ObjectFeederTest, TexturesWaitForTheirRevision) {
  ObjectFeeder feeder(store());
  ASSERT_TRUE(feeder.Add(Texture(1)));  // of a mission nobody has heard of
  ASSERT_TRUE(feeder.Add(Report(1)));
  EXPECT_EQ(feeder.counts().textures, 1U);
  ASSERT_TRUE(feeder.Add(Texture(3)));  // of a revision that was lost, until it is said again
  ASSERT_TRUE(feeder.Add(Report(2)));
  EXPECT_EQ(feeder.counts().textures, 1U);
  ASSERT_TRUE(feeder.Add(Report(3)));
  EXPECT_EQ(feeder.counts().textures, 2U);
  EXPECT_EQ(feeder.counts().orphans, 0U);
}

TEST_F(ObjectFeederTest, AfterARestartTexturesFindTheObjectThatIsSaidAgain) {
  {
    ObjectFeeder feeder(store());
    ASSERT_TRUE(feeder.Add(Report(1)));
  }
  ObjectFeeder feeder(store());
  ASSERT_TRUE(feeder.Add(Texture(1)));
  ASSERT_TRUE(feeder.Add(Report(1)));
  EXPECT_EQ(feeder.counts().known, 1U);
  EXPECT_EQ(feeder.counts().textures, 1U);
}

TEST_F(ObjectFeederTest, WhatWaitsIsBounded) {
  ObjectFeeder feeder(store());
  for (std::uint64_t revision = 1; revision <= 40; ++revision)
    ASSERT_TRUE(feeder.Add(Texture(revision)));
  EXPECT_EQ(feeder.counts().orphans, 24U);
}

TEST_F(ObjectFeederTest, AStoreThatWasDeletedUnderItIsMadeAnew) {
  ObjectFeeder feeder(store());
  ASSERT_TRUE(feeder.Add(Report(1)));
  for (const char* ending : {"", "-wal", "-shm"}) fs::remove(store() + ending);
  ASSERT_TRUE(feeder.Add(Report(2)));
  EXPECT_TRUE(fs::exists(store()));
  EXPECT_EQ(Newest(), 2U);
}

TEST_F(ObjectFeederTest, ObjectsThatCannotBeRegisteredHoldUpNothingElse) {
  std::ofstream(folder_ / "textures") << "a file where the folder of textures belongs";
  std::string said;
  auto feeder = StoreFeeder::Create({.target = store()}, "",
                                    [&said](const std::string& line) { said += line + "\n"; });
  ASSERT_TRUE(feeder);
  feeder->Put({.record = Report(1), .received = {}});
  gis::EventRecord event;
  event.robot = "rover";
  event.mission = "m1";
  event.time = core::ToGps(At(1));
  event.mono = core::MonoTime::FromNs(1);
  event.name = "battery.low";
  feeder->Put({.record = event, .received = {}});
  ASSERT_TRUE(feeder->Commit());
  EXPECT_EQ(feeder->stats().events, 1U);
  EXPECT_EQ(feeder->pending(), 1U);
  EXPECT_NE(said.find("changed objects: "), std::string::npos) << said;
  fs::remove(folder_ / "textures");
  ASSERT_TRUE(feeder->Finish());
  EXPECT_EQ(feeder->pending(), 0U);
  EXPECT_EQ(feeder->objects().revisions, 1U);
  EXPECT_NE(said.find("registered again"), std::string::npos) << said;
}

}  // namespace
}  // namespace kawara::station
