#include "tools/navigate/safe_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/navigate/test_files.hpp"

namespace kawara::navigate {
namespace {

using ::testing::HasSubstr;

class SafeFileTest : public WithFiles {
 protected:
  static std::string Content(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
};

TEST_F(SafeFileTest, ThereOnlyWhenCommitted) {
  const std::string path = Path("out.csv");
  auto file = SafeFile::Create(path);
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_TRUE(file->Write("hello\n"));
  EXPECT_FALSE(std::filesystem::exists(path));
  ASSERT_TRUE(file->Commit());
  EXPECT_EQ(Content(path), "hello\n");
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST_F(SafeFileTest, WhatWasThereStaysUntilCommitted) {
  const std::string path = File("old\n", "out.csv");
  {
    auto file = SafeFile::Create(path);
    ASSERT_TRUE(file && file->Write("half of the n"));
  }
  EXPECT_EQ(Content(path), "old\n");
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST_F(SafeFileTest, FullDiskIsAnErrorAndTheDeviceStays) {
  auto file = SafeFile::Create("/dev/full");
  ASSERT_TRUE(file) << file.error().message;
  auto ok = file->Write("x");
  if (ok) ok = file->Commit();
  ASSERT_FALSE(ok);
  EXPECT_EQ(ok.error().code, core::ErrorCode::kFull);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(SafeFileTest, PlacesThatCannotBe) {
  EXPECT_THAT(SafeFile::Create(Path("no/such/folder/x")).error().message,
              HasSubstr("No such file"));
  EXPECT_THAT(SafeFile::Create(Path("")).error().message, HasSubstr("is a directory"));
}

}  // namespace
}  // namespace kawara::navigate
