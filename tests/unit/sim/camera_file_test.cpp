#include "sim/camera/camera_file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace kawara::sim {
namespace {

class CameraFile : public ::testing::Test {
 protected:
  CameraFile() {
    std::string pattern = (std::filesystem::temp_directory_path() / "kawara-cam-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~CameraFile() override { std::filesystem::remove_all(folder_); }
  core::Expected<vision::CameraChoice> Read(const std::string& yaml) const {
    const std::string path = (folder_ / "camera.yaml").string();
    std::ofstream(path) << yaml;
    return LoadCamera(path);
  }
  std::filesystem::path folder_;
};

TEST_F(CameraFile, AFileOfEveryModelIsReadBack) {
  for (const char* name : {"doughnut", "equirectangular"}) {
    vision::CameraChoice choice;
    choice.camera = name;
    choice.doughnut = choice.doughnut.Resized(1448, 1448);
    choice.doughnut.mirrored = true;
    choice.equirectangular = {1000, 300, 1200, 600, 100, 120};
    const auto back = Read(DumpCamera(choice));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(DumpCamera(*back), DumpCamera(choice));
    const auto camera = vision::MakeCamera(*back);
    ASSERT_TRUE(camera) << camera.error().message;
    const auto ray = (*vision::MakeCamera(choice))->Unproject({500, 200});
    const auto same = (*camera)->Unproject({500, 200});
    ASSERT_TRUE(ray && same);
    EXPECT_LT((*ray - *same).norm(), 1e-12);
  }
}

TEST_F(CameraFile, MistakesAreSaidWithTheirPlace) {
  const auto wrong = Read("camera: pinhole\nfocal_px: 3\n");
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("camera.yaml:1:"), std::string::npos)
      << wrong.error().message;
  EXPECT_NE(wrong.error().message.find("focal_px"), std::string::npos) << wrong.error().message;
  const auto crop = Read(
      "camera: equirectangular\n"
      "equirectangular: {width_px: 3000, height_px: 600, full_width_px: 2000}\n");
  ASSERT_FALSE(crop);
  EXPECT_NE(crop.error().message.find("camera.yaml"), std::string::npos) << crop.error().message;
}

}  // namespace
}  // namespace kawara::sim
