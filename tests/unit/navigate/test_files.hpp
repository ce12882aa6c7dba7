#pragma once
#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace kawara::navigate {

/// A folder of its own for every test, gone afterwards.
class WithFiles : public ::testing::Test {
 protected:
  WithFiles() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("kawara-navigate-" + std::to_string(::getpid()) + "-" + info->name());
    std::filesystem::create_directories(folder_);
  }
  ~WithFiles() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string File(const std::string& text, const std::string& name = "file.csv") const {
    std::ofstream(Path(name), std::ios::binary) << text;
    return Path(name);
  }
  std::string GzipFile(const std::string& text, const std::string& name = "file.csv.gz") const {
    const gzFile file = ::gzopen(Path(name).c_str(), "wb");
    ::gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    ::gzclose(file);
    return Path(name);
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace kawara::navigate
