#include "gis/model/whole_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/support/test_folder.hpp"

namespace kawara::gis {
namespace {

namespace fs = std::filesystem;
using testing::TestFolder;

std::size_t FilesIn(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WholeFile, TakesTheOldOnesPlace) {
  TestFolder folder;
  ASSERT_TRUE(WriteWholeFile(folder / "a", "first"));
  ASSERT_TRUE(WriteWholeFile(folder / "a", "2nd"));
  std::ifstream file(folder / "a");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "2nd");
  EXPECT_EQ(FilesIn(folder.path()), 1U);
}

TEST(WholeFile, IsCheckedWithoutATrace) {
  TestFolder folder;
  EXPECT_TRUE(CheckWritable(folder / "new/er/report.html"));
  EXPECT_EQ(FilesIn(folder / "new/er"), 0U);
  ASSERT_TRUE(WriteWholeFile(folder / "old", "kept"));
  EXPECT_TRUE(CheckWritable(folder / "old"));
  EXPECT_EQ(fs::file_size(folder / "old"), 4U);
}

TEST(WholeFile, WhatCannotBeWrittenIsSaidWithItsName) {
  TestFolder folder;
  ASSERT_TRUE(WriteWholeFile(folder / "file", ""));
  for (const fs::path& path : {folder.path(), folder / "folder/", folder / "file/report.html",
                               fs::path("/proc/report"), folder / std::string(300, 'x')}) {
    const auto writable = CheckWritable(path);
    ASSERT_FALSE(writable) << path;
    EXPECT_NE(writable.error().message.find(path.parent_path().string()), std::string::npos)
        << writable.error().message;
    EXPECT_FALSE(WriteWholeFile(path, "x")) << path;
  }
}

}  // namespace
}  // namespace kawara::gis
