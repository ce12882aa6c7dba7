#include "tests/bench/changes/judge_textures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>

#include "sim/render/frame_files.hpp"
#include "sim/render/renderer.hpp"
#include "vision/sides/side_texture.hpp"

namespace kawara::change_bench {
namespace {

constexpr double kApartM = 2.0, kReachM = 15.0, kEyeM = 3.0;
constexpr int kSearchPx = 20;

/// Sees one side of a box, a pixel a texel, from before its middle. The camera's frame is the
/// map's.
class SideCamera final : public vision::CameraModel {
 public:
  SideCamera(const core::UprightBox& box, core::BoxSide side, int width_px, int height_px)
      : width_px_(width_px), height_px_(height_px) {
    const auto corners = box.CornersOf(side);
    right_ = corners[1] - corners[0];
    down_ = corners[3] - corners[0];
    const Eigen::Vector3d normal = down_.cross(right_).normalized();
    eye_m_ = corners[0] + 0.5 * (right_ + down_) + kEyeM * normal;
    to_corner_ = corners[0] - eye_m_;
  }
  const Eigen::Vector3d& eye_m() const { return eye_m_; }

  int width_px() const override { return width_px_; }
  int height_px() const override { return height_px_; }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray) const override {
    Eigen::Matrix3d through;
    through << right_, down_, to_corner_;
    const Eigen::Vector3d at = through.inverse() * ray;
    if (!(at.z() > 0.0)) return std::nullopt;
    return Eigen::Vector2d(at.x() / at.z() * width_px_ - 0.5, at.y() / at.z() * height_px_ - 0.5);
  }
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const override {
    return (to_corner_ + (pixel.x() + 0.5) / width_px_ * right_ +
            (pixel.y() + 0.5) / height_px_ * down_)
        .normalized();
  }
  vision::ElevationRange Elevations() const override { return {}; }

 private:
  int width_px_, height_px_;
  Eigen::Vector3d right_, down_, to_corner_, eye_m_;
};

/// Brightness, rows from the top.
struct Grey {
  int width_px = 0, height_px = 0;
  std::vector<double> level;
  double at(int u, int v) const {
    return level[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px) +
                 static_cast<std::size_t>(u)];
  }
};

Grey GreyOf(const vision::ConstImageView& picture, int left, int top, int width, int height) {
  Grey grey{width, height, {}};
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const std::uint8_t* const rgb =
          picture.row(top + v) + std::ptrdiff_t{vision::kRgbBytes} * (left + u);
      grey.level.push_back((rgb[0] + 2.0 * rgb[1] + rgb[2]) / 4.0);
    }
  return grey;
}

/// Of a(u, v) with b(u + du, v + dv), where both are.
double Correlation(const Grey& a, const Grey& b, int du, int dv) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (int v = std::max(0, -dv); v < std::min(a.height_px, a.height_px - dv); ++v)
    for (int u = std::max(0, -du); u < std::min(a.width_px, a.width_px - du); ++u) {
      const double p = a.at(u, v), q = b.at(u + du, v + dv);
      n += 1, x += p, y += q, xx += p * p, yy += q * q, xy += p * q;
    }
  const double spread = (xx - x * x / n) * (yy - y * y / n);
  return spread > 0.0 ? (xy - x * y / n) / std::sqrt(spread) : 0.0;
}

void FindShift(const Grey& texture, const Grey& truth, JudgedSide& side) {
  side.correlation = side.aligned = Correlation(texture, truth, 0, 0);
  const int reach_u = std::min(kSearchPx, texture.width_px / 3);
  const int reach_v = std::min(kSearchPx, texture.height_px / 3);
  for (int dv = -reach_v; dv <= reach_v; ++dv)
    for (int du = -reach_u; du <= reach_u; ++du) {
      const double correlation = Correlation(texture, truth, du, dv);
      if (correlation <= side.aligned) continue;
      side.aligned = correlation;
      side.off_px = std::hypot(du, dv);
    }
}

double CpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The drive's pictures 2 m apart, as taken and as believed.
struct Looks {
  std::vector<Picture> measured;
  std::vector<sim::RenderedFrame> frames;
  std::vector<std::string> names;

  std::vector<vision::SideView> Near(const vision::CameraModel& camera,
                                     const core::UprightBox& box) const {
    std::vector<vision::SideView> views;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const auto& place = measured[i].map_from_camera.translation();
      if ((place - box.centre_m).head<2>().norm() > kReachM) continue;
      views.push_back({.view = {.camera = camera,
                                .picture = frames[i].view(),
                                .ranges = &measured[i].ranges,
                                .map_from_camera = measured[i].map_from_camera},
                       .source = names[i]});
    }
    return views;
  }
};

Looks Take(const ChangeDrive& drive, const Errors& errors, std::uint64_t draw,
           const sim::Renderer& renderer) {
  Looks looks;
  Eigen::Vector3d last = Eigen::Vector3d::Constant(1e9);
  for (int i = 0; i < drive.pictures(); ++i) {
    const Eigen::Isometry3d pose = drive.TruePose(i);
    if ((pose.translation() - last).norm() < kApartM) continue;
    last = pose.translation();
    looks.measured.push_back(drive.Take(i, errors, draw));
    looks.frames.push_back(renderer.Render(
        {.enu_from_camera = sim::Still(pose), .noise_seed = static_cast<std::uint64_t>(i) + 1}));
    looks.names.push_back("drive/" + std::to_string(i));
  }
  return looks;
}

}  // namespace

core::Expected<std::vector<JudgedSide>> JudgeTextures(const ChangeDrive& drive,
                                                      const Errors& errors, std::uint64_t draw,
                                                      const vision::Findings& found,
                                                      const std::string& folder) {
  std::vector<JudgedSide> judged;
  if (found.changes.empty()) return judged;
  const auto lit = drive.Lit();
  if (!lit) return tl::unexpected(lit.error());
  const Looks looks = Take(drive, errors, draw, sim::Renderer(*lit, drive.camera(), {}));
  sim::CameraSettings clean;
  clean.lens = {.vignetting = 0.0, .dirt_spots = 0};
  clean.sensor.full_well_e = 0.0;
  vision::JpegEncoder encoder;
  vision::JpegDecoder decoder;
  for (std::size_t n = 0; n < found.changes.size(); ++n) {
    core::ChangedObject object = found.changes[n].object;
    object.uid = "object-" + std::to_string(n + 1);
    const double start = CpuSeconds();
    const auto textures =
        vision::MakeSideTextures(object, looks.Near(*drive.camera(), object.box), {}, encoder);
    const double make_s = CpuSeconds() - start;
    if (!textures) return tl::unexpected(textures.error());
    if (textures->faces.empty()) continue;
    const auto atlas = decoder.Decode(textures->atlas_jpeg);
    if (!atlas) return tl::unexpected(atlas.error());
    if (!folder.empty()) {
      std::filesystem::create_directories(folder);
      std::ofstream(folder + "/" + object.uid + ".jpg", std::ios::binary)
          .write(reinterpret_cast<const char*>(textures->atlas_jpeg.data()),
                 static_cast<std::streamsize>(textures->atlas_jpeg.size()));
    }
    for (const core::FaceTexture& face : textures->faces) {
      const auto& c = face.corners_px;
      const int left = static_cast<int>(c[0][0]), top = static_cast<int>(c[0][1]);
      const int width = static_cast<int>(c[2][0]) - left, height = static_cast<int>(c[2][1]) - top;
      const auto camera = std::make_shared<SideCamera>(object.box, face.side, width, height);
      Eigen::Isometry3d eye = Eigen::Isometry3d::Identity();
      eye.translation() = camera->eye_m();
      const sim::RenderedFrame truth =
          sim::Renderer(*lit, camera, clean).Render({.enu_from_camera = sim::Still(eye)});
      JudgedSide side{.uid = object.uid,
                      .side = face.side,
                      .seen_share = face.seen_share,
                      .make_s = make_s,
                      .atlas_kb = 1e-3 * static_cast<double>(textures->atlas_jpeg.size())};
      const auto corners = object.box.CornersOf(face.side);
      side.texel_m = (corners[1] - corners[0]).norm() / width;
      FindShift(GreyOf(*atlas, left, top, width, height), GreyOf(truth.view(), 0, 0, width, height),
                side);
      judged.push_back(side);
      if (folder.empty()) continue;
      const std::string name =
          folder + "/" + object.uid + "_" + core::ToString(face.side) + "_truth.png";
      if (auto good = sim::WriteColourPng(truth, name); !good) return tl::unexpected(good.error());
    }
  }
  return judged;
}

}  // namespace kawara::change_bench
