#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>
#include <thread>

#include "fixture.hpp"
#include "gis/ogr_dataset.hpp"
#include "gis/store.hpp"

/// What the world does to a store: kills, full disks, locks, read-only folders.
namespace kawara::gis {
namespace {

using namespace testing;
using ::testing::HasSubstr;

constexpr int kEpochs = 40;

/// Everything of a little mission; after each flush `acknowledged(epoch)`.
template <class Acknowledge>
void WriteMission(const std::filesystem::path& path, Acknowledge acknowledged) {
  auto store = SpatioTemporalStore::Open({.target = path.string()});
  if (!store) throw std::runtime_error(store.error().message);
  const auto must = [](const core::Expected<void>& done) {
    if (!done) throw std::runtime_error(done.error().message);
  };
  for (int epoch = 1; epoch <= kEpochs; ++epoch) {
    must(store->AddPose(Pose(epoch)));
    must(store->AddPanorama(Panorama(epoch, PictureStage::kPreview)));
    must(store->Flush());
    must(store->AddPanorama(Panorama(epoch, PictureStage::kFull)));
    must(store->Flush());
    acknowledged(epoch);
  }
  must(store->Close());
}

/// Runs `work` in a child process that ends by _exit(0), or 1 with a word on stderr.
template <class Work>
pid_t Fork(Work work) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  try {
    work();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "child: %s\n", e.what());
    ::_exit(1);
  }
  ::_exit(0);
}

int KillsWanted() {
  const char* wanted = std::getenv("KAWARA_KILLS");
  return wanted != nullptr ? std::atoi(wanted) : 16;
}

TEST(StoreFaults, KilledAtAnyMomentItOpensAndHoldsWhatWasAcknowledged) {
  TestFolder folder;
  WriteMission(folder / "whole/store.gpkg", [](int) {});
  const std::string whole = Dump(folder / "whole/store.gpkg");
  ASSERT_THAT(whole, HasSubstr("# obs_panorama: 40 rows"));
  std::mt19937 random(7);
  int interrupted = 0;
  for (int kill = 0; kill < KillsWanted(); ++kill) {
    // Every third store is new, so that its making is hit too; the others are written again and
    // again.
    const auto path = folder / ("killed" + std::to_string(kill / 3) + "/store.gpkg");
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
    const pid_t child = Fork([&] {
      WriteMission(path, [&](int epoch) {
        const auto byte = static_cast<char>(epoch);
        if (::write(pipe[1], &byte, 1) != 1) throw std::runtime_error("pipe");
      });
    });
    ::close(pipe[1]);
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 250'000));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) ++interrupted;
    char acknowledged = 0;
    while (::read(pipe[0], &acknowledged, 1) == 1) {
    }
    ::close(pipe[0]);
    if (!std::filesystem::exists(path)) {
      ASSERT_EQ(acknowledged, 0) << "acknowledged, but there is no store";
      continue;
    }
    // Half of them are read at once, by a reader alone; the others as a station does that starts
    // again: it opens the store, which finishes what the kill broke off.
    if (kill % 2 == 0) {
      auto mended = SpatioTemporalStore::Open({.target = path});
      ASSERT_TRUE(mended) << mended.error().message;
      ASSERT_TRUE(mended->Close());
    }
    const std::string dump = Dump(path);  // fails if a row's picture is missing or wrong
    for (int epoch = 1; epoch <= acknowledged; ++epoch) {
      const std::string row = "epoch=" + std::to_string(epoch) + "\tstage=full";
      ASSERT_THAT(dump, HasSubstr(row))
          << "kill " << kill << ": acknowledged " << int{acknowledged};
    }
    if (kill % 5 == 4) {  // going on where it was killed leads to the same store
      WriteMission(path, [](int) {});
      ASSERT_EQ(Dump(path), whole);
    }
  }
  EXPECT_GT(interrupted, 0) << "the kills came too late to prove anything";
}

TEST(StoreFaults, AFullDiskLosesNothingAndIsGotOverWhenThereIsSpace) {
  TestFolder folder;
  WriteMission(folder / "whole/store.gpkg", [](int) {});
  const pid_t child = Fork([&] {
    const auto path = folder / "full/store.gpkg";
    auto store = SpatioTemporalStore::Open({.target = path.string()});
    if (!store) throw std::runtime_error(store.error().message);
    ::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit little = before;
    for (int epoch = 1; epoch <= kEpochs; ++epoch) {
      // No file may grow beyond this: at first not even a picture, then not the store.
      little.rlim_cur = epoch < 20 ? 1000 : 20'000;
      ::setrlimit(RLIMIT_FSIZE, &little);
      if (!store->AddPose(Pose(epoch)) ||
          !store->AddPanorama(Panorama(epoch, PictureStage::kPreview)) ||
          !store->AddPanorama(Panorama(epoch, PictureStage::kFull)))
        throw std::runtime_error("not taken in");
      const auto flushed = store->Flush();
      if (flushed) throw std::runtime_error("a full disk took it");
      if (epoch == 1 && flushed.error().code != core::ErrorCode::kFull)
        throw std::runtime_error("not said to be full: " + flushed.error().message);
      if (epoch % 10 == 0) {
        ::setrlimit(RLIMIT_FSIZE, &before);
        if (auto done = store->Flush(); !done) throw std::runtime_error(done.error().message);
        if (store->pending() != 0) throw std::runtime_error("still pending");
      }
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    if (auto done = store->Close(); !done) throw std::runtime_error(done.error().message);
  });
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(Dump(folder / "full/store.gpkg"), Dump(folder / "whole/store.gpkg"));
}

TEST(StoreFaults, ALockedDatabaseIsSaidAndGotOver) {
  TestFolder folder;
  const auto path = folder / "store.gpkg";
  auto store = SpatioTemporalStore::Open({.target = path.string()});
  ASSERT_TRUE(store) << store.error().message;
  auto other = OgrDataset::Open(path.string(), false);
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_TRUE(other->Begin());
  ASSERT_TRUE(other->Execute("UPDATE gpkg_contents SET description = 'being edited'"));
  ASSERT_TRUE(store->AddPose(Pose(1)));
  const auto locked = store->Flush();
  ASSERT_FALSE(locked);
  EXPECT_EQ(locked.error().code, core::ErrorCode::kUnavailable) << locked.error().message;
  EXPECT_THAT(locked.error().message, HasSubstr("another program is writing to it"));
  EXPECT_EQ(locked.error().message.find('\n'), std::string::npos);
  EXPECT_EQ(store->pending(), 1U);
  other->Rollback();
  ASSERT_TRUE(store->Flush());
  ASSERT_TRUE(store->Close());
  EXPECT_THAT(Dump(path), HasSubstr("# obs_pose: 1 rows"));
}

TEST(StoreFaults, PendingIsBounded) {
  TestFolder folder;
  auto store = SpatioTemporalStore::Open(
      {.target = (folder / "store.gpkg").string(), .max_pending_bytes = 10'000});
  ASSERT_TRUE(store) << store.error().message;
  ASSERT_TRUE(store->AddPanorama(Panorama(1, PictureStage::kFull)));
  ASSERT_TRUE(store->AddPanorama(Panorama(2, PictureStage::kFull)));
  const auto third = store->AddPanorama(Panorama(3, PictureStage::kFull));
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().code, core::ErrorCode::kFull);
  ASSERT_TRUE(store->Close());
  EXPECT_THAT(Dump(folder / "store.gpkg"), HasSubstr("# obs_panorama: 2 rows"));
}

TEST(StoreFaults, AStaleTrajectoryIsMendedWhenOpened) {
  TestFolder folder;
  const auto path = folder / "store.gpkg";
  WriteMission(path, [](int) {});
  const std::string whole = Dump(path);
  // As a kill leaves it between two writings of a growing line.
  Shell("ogrinfo -q " + path.string() + " -sql \"update trajectory set poses = 3\"");
  ASSERT_NE(Dump(path), whole);
  auto store = SpatioTemporalStore::Open({.target = path.string()});
  ASSERT_TRUE(store) << store.error().message;
  ASSERT_TRUE(store->Close());
  EXPECT_EQ(Dump(path), whole);
}

struct Unusable {
  const char* name;
  std::function<std::string(const TestFolder&)> make;
  core::ErrorCode code;
  const char* says;
};

class StoreOpenFaults : public ::testing::TestWithParam<Unusable> {};

TEST_P(StoreOpenFaults, OneClearLine) {
  TestFolder folder;
  const auto store = SpatioTemporalStore::Open({.target = GetParam().make(folder)});
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, GetParam().code) << store.error().message;
  EXPECT_THAT(store.error().message, HasSubstr(GetParam().says));
  EXPECT_EQ(store.error().message.find('\n'), std::string::npos) << store.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    , StoreOpenFaults,
    ::testing::Values(
        Unusable{"Nothing", [](const auto&) { return ""; }, core::ErrorCode::kInvalidArgument,
                 "no store named"},
        Unusable{"Folder", [](const auto& f) { return f.path().string(); },
                 core::ErrorCode::kInvalidArgument, "is a folder"},
        Unusable{"TextFile",
                 [](const auto& f) {
                   std::ofstream(f / "store.gpkg")
                       << "not a database, but long enough to be looked at\n";
                   return (f / "store.gpkg").string();
                 },
                 core::ErrorCode::kFormat, "not a GeoPackage"},
        Unusable{"OtherShape",
                 [](const auto& f) {
                   Shell("ogr2ogr -f GPKG " + (f / "store.gpkg").string() +
                         " '{\"type\":\"Point\",\"coordinates\":[139.7,35.7]}' -nln obs_pose");
                   return (f / "store.gpkg").string();
                 },
                 core::ErrorCode::kFormat, "layer obs_pose has no field robot"},
        Unusable{"FileWhereTheFolderShouldBe",
                 [](const auto& f) {
                   std::ofstream(f / "here") << "x";
                   return (f / "here/store.gpkg").string();
                 },
                 core::ErrorCode::kIo, "Not a directory"},
        Unusable{"ProcIsReadOnly", [](const auto&) { return "/proc/store/store.gpkg"; },
                 core::ErrorCode::kNotFound, "mkdir /proc/store"},
        Unusable{"NoServer",
                 [](const auto&) { return "PG:host=127.0.0.1 port=1 dbname=x password=secret"; },
                 core::ErrorCode::kUnavailable, "is the server running?"}),
    [](const auto& test) { return test.param.name; });

TEST(StoreFaults, APasswordIsNotInTheMessage) {
  const auto store =
      SpatioTemporalStore::Open({.target = "PG:host=127.0.0.1 port=1 password='my secret' dbname=x",
                                 .pictures_dir = std::filesystem::temp_directory_path()});
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().message.find("my secret"), std::string::npos) << store.error().message;
  EXPECT_THAT(store.error().message, HasSubstr("password=*** dbname=x"));
}

}  // namespace
}  // namespace kawara::gis
