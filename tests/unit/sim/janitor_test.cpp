#include "sim/ports/janitor.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

namespace kawara::sim {
namespace {

namespace fs = std::filesystem;

fs::path NewFile(const char* name) {
  const fs::path file = fs::path(::testing::TempDir()) / name;
  std::ofstream(file) << "x";
  return file;
}

/// The janitor needs a moment; waits long, because a busy machine may.
bool Disappears(const fs::path& file) {
  for (int i = 0; i < 500; ++i) {
    if (!fs::exists(file)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

TEST(Janitor, AKilledOwnersFilesGo) {
  const fs::path file = NewFile("kawara_janitor_killed");
  const pid_t owner = fork();
  if (owner == 0) {
    const Janitor janitor({file});
    raise(SIGKILL);
  }
  waitpid(owner, nullptr, 0);
  EXPECT_TRUE(Disappears(file));
}

TEST(Janitor, AnOwnerThatLeavesInPeaceKeepsItsFiles) {
  const fs::path file = NewFile("kawara_janitor_peace");
  { const Janitor janitor({file}); }
  EXPECT_TRUE(fs::exists(file));
  fs::remove(file);
}

TEST(Janitor, HoldsNothingOfItsOwnerOpen) {
  const fs::path file = NewFile("kawara_janitor_pipe");
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  {
    const Janitor janitor({file});
    close(ends[1]);
    char byte = 0;
    EXPECT_EQ(read(ends[0], &byte, 1), 0) << "the other end is closed, everywhere";
  }
  close(ends[0]);
  fs::remove(file);
}

}  // namespace
}  // namespace kawara::sim
