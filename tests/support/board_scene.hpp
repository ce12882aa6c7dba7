#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "core/geodesy.hpp"
#include "vision/calibration/board.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/png.hpp"

/// A chessboard held before a camera of known optics: where its corners are, and what it looks
/// like.
namespace kawara::vision {

/// How a board is held: its middle at `angle_rad` from the optical axis and `azimuth_rad` about it,
/// facing the camera but for a slant about an axis in its own plane.
struct BoardHold {
  double angle_rad = 0.0, azimuth_rad = 0.0, distance_m = 0.5;
  double slant_rad = 0.0, slant_azimuth_rad = 0.0, roll_rad = 0.0;
};

/// `count` holds, all around, between two angles from the axis, slanted by up to 40 deg.
inline std::vector<BoardHold> HoldsAround(double low_rad, double high_rad, int count,
                                          unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<BoardHold> holds;
  for (int i = 0; i < count; ++i) {
    BoardHold hold;
    // The golden angle: no two at one azimuth.
    hold.azimuth_rad = 2.39996 * i;
    hold.angle_rad = low_rad + (high_rad - low_rad) * (i + 0.5) / count;
    hold.distance_m = 0.2 + 0.15 * unit(random);
    hold.slant_rad = (15.0 + 25.0 * unit(random)) * core::kRadFromDeg;
    hold.slant_azimuth_rad = 2.0 * core::kPi * unit(random);
    hold.roll_rad = 2.0 * core::kPi * unit(random);
    holds.push_back(hold);
  }
  return holds;
}

/// Takes the board's (x, y, 0) [m] to the camera frame of camera_model.hpp. `camera` is symmetric.
inline Eigen::Isometry3d CameraFromBoard(const CameraModel& camera, const Board& board,
                                         const BoardHold& hold) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const Vector3d away(std::sin(hold.angle_rad) * std::cos(hold.azimuth_rad),
                      std::sin(hold.angle_rad) * std::sin(hold.azimuth_rad),
                      std::cos(hold.angle_rad));
  const Eigen::Quaterniond facing = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), away);
  const Vector3d slant_axis(std::cos(hold.slant_azimuth_rad), std::sin(hold.slant_azimuth_rad),
                            0.0);
  Eigen::Isometry3d optical_from_board = Eigen::Isometry3d::Identity();
  optical_from_board.linear() = (facing * AngleAxisd(hold.slant_rad, slant_axis) *
                                 AngleAxisd(hold.roll_rad, Vector3d::UnitZ()))
                                    .toRotationMatrix();
  const Vector3d middle(0.5 * (board.cols - 1) * board.square_m,
                        0.5 * (board.rows - 1) * board.square_m, 0.0);
  optical_from_board.translation() = away * hold.distance_m - optical_from_board.linear() * middle;
  Eigen::Isometry3d camera_from_optical = Eigen::Isometry3d::Identity();
  camera_from_optical.linear() = camera.Symmetry()->R_optical_camera.transpose();
  return camera_from_optical * optical_from_board;
}

/// The inner corners that the picture shows, with normal noise of `sd_px` each way.
inline BoardView SeenCorners(const CameraModel& camera, const Board& board,
                             const Eigen::Isometry3d& camera_from_board, double sd_px,
                             std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, sd_px > 0.0 ? sd_px : 1.0);
  BoardView view;
  for (int row = 0; row < board.rows; ++row) {
    for (int col = 0; col < board.cols; ++col) {
      const Eigen::Vector3d point =
          camera_from_board * Eigen::Vector3d(col * board.square_m, row * board.square_m, 0.0);
      const auto pixel = camera.Project(point);
      if (!pixel || pixel->minCoeff() < 4.0 || pixel->x() > camera.width_px() - 5.0 ||
          pixel->y() > camera.height_px() - 5.0) {
        continue;
      }
      view.push_back({col, row, *pixel});
      if (sd_px > 0.0) view.back().pixel_px += Eigen::Vector2d(noise(random), noise(random));
    }
  }
  return view;
}

struct BoardLook {
  double blur_px = 0.6;   ///< the lens's point spread, standard deviation
  double noise_sd = 2.0;  ///< of a pixel [levels]
  std::uint8_t white = 220, black = 25, around = 120;
  std::uint8_t unseen = 0;  ///< where the camera has no ray
};

/// The picture of a board with a white rim of half a square around, on grey. Every pixel is the
/// mean over its neighbourhood by the blur, each ray met with the board by itself.
inline RgbPicture RenderBoard(const CameraModel& camera, const Board& board,
                              const Eigen::Isometry3d& camera_from_board, const BoardLook& look,
                              unsigned seed) {
  const Eigen::Isometry3d board_from_camera = camera_from_board.inverse();
  const auto level = [&](double u, double v) -> double {
    const auto ray = camera.Unproject({u, v});
    if (!ray) return look.unseen;
    const Eigen::Vector3d direction = board_from_camera.linear() * *ray;
    const double along = -board_from_camera.translation().z() / direction.z();
    if (!(along > 0.0)) return look.around;
    const Eigen::Vector3d met = board_from_camera.translation() + along * direction;
    const double col = met.x() / board.square_m + 1.0, row = met.y() / board.square_m + 1.0;
    if (col < -0.5 || row < -0.5 || col > board.cols + 1.5 || row > board.rows + 1.5) {
      return look.around;
    }
    if (col < 0.0 || row < 0.0 || col > board.cols + 1.0 || row > board.rows + 1.0) {
      return look.white;
    }
    const auto parity = static_cast<int>(std::floor(col)) + static_cast<int>(std::floor(row));
    return parity % 2 == 0 ? look.black : look.white;
  };
  // Offsets of equal weight, normally distributed each way: the middles of slices of equal area.
  constexpr double kSlices[] = {-1.5341, -0.8871, -0.4888, -0.1573, 0.1573, 0.4888, 0.8871, 1.5341};
  constexpr double kSpread = 1.025;  // the slices' middles spread less than the whole
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, look.noise_sd);
  RgbPicture picture;
  picture.width_px = camera.width_px();
  picture.height_px = camera.height_px();
  picture.rgb.resize(picture.view().size_bytes());
  const auto width = static_cast<std::size_t>(picture.width_px);
  std::vector<double> middles;
  for (int v = 0; v < picture.height_px; ++v) {
    for (int u = 0; u < picture.width_px; ++u) middles.push_back(level(u, v));
  }
  // Flat all around needs no samples.
  const auto flat = [&](int u, int v) {
    const double middle =
        middles[static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u)];
    for (int b = std::max(0, v - 2); b <= std::min(picture.height_px - 1, v + 2); ++b) {
      for (int a = std::max(0, u - 2); a <= std::min(picture.width_px - 1, u + 2); ++a) {
        if (middles[static_cast<std::size_t>(b) * width + static_cast<std::size_t>(a)] != middle) {
          return false;
        }
      }
    }
    return true;
  };
  std::size_t i = 0;
  for (int v = 0; v < picture.height_px; ++v) {
    for (int u = 0; u < picture.width_px; ++u) {
      double value = middles[i / kRgbBytes];
      if (!flat(u, v)) {
        value = 0.0;
        for (const double du : kSlices) {
          for (const double dv : kSlices) {
            value += level(u + kSpread * look.blur_px * du, v + kSpread * look.blur_px * dv) / 64.0;
          }
        }
      }
      const auto byte =
          static_cast<std::uint8_t>(std::clamp(std::lround(value + noise(random)), 0L, 255L));
      for (int c = 0; c < kRgbBytes; ++c) picture.rgb[i++] = byte;
    }
  }
  return picture;
}

}  // namespace kawara::vision
