// render_boards FOLDER COUNT: rendered pictures of a 9 x 6 board of 0.03 m through a
// known fisheye, 00.png, 01.png ..., and the camera that made them as truth.txt: "u v x y z" lines,
// pixels and their rays.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/board_scene.hpp"
#include "tests/unit/vision_calibration/known_cameras.hpp"

int main(int argc, char** argv) {
  using namespace kawara::vision;
  if (argc < 3) {
    std::fprintf(stderr, "render_boards FOLDER COUNT\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    std::fprintf(stderr, "render_boards: %s: %s\n", argv[1], error.message().c_str());
    return 2;
  }
  const KnownCamera known = KnownCameras().back();
  const auto camera = MakeCamera(known.choice);
  if (!camera) return 1;
  const Board board{.cols = 9, .rows = 6, .square_m = 0.03};
  int number = 0;
  for (const BoardHold& hold : HoldsAround(known.low_rad, known.high_rad, std::atoi(argv[2]), 3)) {
    const Eigen::Isometry3d pose = CameraFromBoard(**camera, board, hold);
    const RgbPicture picture =
        RenderBoard(**camera, board, pose, {}, static_cast<unsigned>(number + 1));
    const auto png = EncodePng(picture.view(), kPngFast);
    if (!png) return 1;
    char name[16];
    std::snprintf(name, sizeof name, "%02d.png", number++);
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(png->data()),
               static_cast<std::streamsize>(png->size()));
  }
  std::ofstream truth(folder / "truth.txt");
  truth.precision(12);
  for (int v = 20; v < kSidePx; v += 40) {
    for (int u = 20; u < kSidePx; u += 40) {
      const auto ray = (*camera)->Unproject({u, v});
      if (ray) truth << u << ' ' << v << ' ' << ray->transpose() << '\n';
    }
  }
  return truth.flush() ? 0 : 1;
}
