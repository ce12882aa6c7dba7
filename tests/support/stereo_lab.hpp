#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"

/// A street of boxes with known ranges, for tests and benchmarks of stereo: ground, walls, two
/// blocks that stand out of them, a truck, a wagon, rubble. Every surface has colour texture of
/// several octaves, walls also bricks and windows. Made anew from a seed, byte for byte; nothing of
/// it is shared with the simulator, whose places are poor in texture as real streets are.
namespace kawara::test_support {

struct StereoLabOptions {
  std::uint32_t seed = 1;
  double vehicle_contrast = 1.0;  ///< of the texture of truck and wagon
  double noise_levels = 2.0;      ///< standard deviation, 8-bit levels
  double blur_px = 0.5;           ///< standard deviation
  int samples = 3;                ///< rays a pixel, along both axes
};

class StereoLab {
 public:
  explicit StereoLab(const StereoLabOptions& options) : options_(options) {
    std::mt19937 dice(options.seed);
    const auto sway = [&](double range) {
      return range * (2.0 * (static_cast<double>(dice()) / 4294967295.0) - 1.0);
    };
    const auto add = [&](double x0, double x1, double y0, double y1, double z1, double contrast,
                         bool bricks) {
      Box box;
      box.low = {x0, y0, -0.5};
      box.high = {x1, y1, z1};
      box.contrast = contrast;
      box.bricks = bricks;
      box.salt = static_cast<std::uint32_t>(dice());
      for (double& c : box.colour) c = 105.0 + sway(45.0);
      boxes_.push_back(box);
    };
    const double paint = options.vehicle_contrast;
    add(-60, 60, 6, 8, 7, 1, true);  // walls
    add(-60, 60, -11, -9, 6, 1, true);
    add(-18, -16, -9, 6, 5, 1, true);
    add(16, 18, -9, 6, 5, 1, true);
    const double a = sway(1.0), b = sway(1.0), c = sway(0.6), d = sway(0.6);
    add(3 + a, 6 + a, 4.1, 6, 3.5, 1, true);  // blocks
    add(-7 + b, -4 + b, -9, -4.8, 4.0, 1, true);
    add(-3.5 + c, 4.0 + c, -4.8, -2.6, 3.0, paint, false);   // truck
    add(-6.5 + d, -1.9 + d, 3.25, 4.95, 1.5, paint, false);  // wagon
    add(5.5 + c, 6.4 + c, -2.2, -1.5, 0.6, 1, false);        // rubble
    add(-5.0 + d, -4.3 + d, -2.9, -2.1, 0.45, 1, false);
    ground_salt_ = static_cast<std::uint32_t>(dice());
  }

  struct Hit {
    double range_m = std::numeric_limits<double>::infinity();
    int box = -1;  ///< -1: ground or nothing
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    bool vehicle() const { return box == 6 || box == 7; }
  };

  /// Along a unit direction.
  Hit Cast(const Eigen::Vector3d& from, const Eigen::Vector3d& along) const {
    Hit hit;
    if (along.z() < -1e-9) {
      hit.range_m = -from.z() / along.z();
      hit.normal = Eigen::Vector3d::UnitZ();
    }
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const Box& box = boxes_[i];
      double enter = 0.0, leave = hit.range_m;
      int axis = -1;
      for (int k = 0; k < 3; ++k) {
        if (std::abs(along[k]) < 1e-12) {
          if (from[k] < box.low[k] || from[k] > box.high[k]) leave = -1.0;
          continue;
        }
        double t0 = (box.low[k] - from[k]) / along[k], t1 = (box.high[k] - from[k]) / along[k];
        if (t0 > t1) std::swap(t0, t1);
        if (t0 > enter) {
          enter = t0;
          axis = k;
        }
        leave = std::min(leave, t1);
      }
      if (axis < 0 || enter >= leave) continue;
      hit.range_m = enter;
      hit.box = static_cast<int>(i);
      hit.normal = Eigen::Vector3d::Zero();
      hit.normal[axis] = along[axis] > 0 ? -1.0 : 1.0;
    }
    return hit;
  }

  /// From a point to the nearest surface [m].
  double DistanceToSurface(const Eigen::Vector3d& point) const {
    double nearest = std::abs(point.z());
    for (const Box& box : boxes_) {
      const Eigen::Array3d beyond = (box.low - point).cwiseMax(point - box.high).array();
      const double distance =
          beyond.maxCoeff() > 0.0 ? beyond.max(0.0).matrix().norm() : std::abs(beyond.maxCoeff());
      nearest = std::min(nearest, distance);
    }
    return nearest;
  }

  struct Frame {
    int width_px = 0, height_px = 0;
    std::vector<std::uint8_t> rgb;
    std::vector<float> range_m;         ///< at pixel centres; infinity: sky, NaN: outside
    std::vector<std::uint8_t> vehicle;  ///< 1: truck or wagon
    vision::ConstImageView view() const { return {rgb.data(), width_px, height_px}; }
  };

  Frame Render(const vision::CameraModel& camera, const Eigen::Isometry3d& map_from_camera,
               std::uint32_t noise_seed) const {
    Frame frame;
    frame.width_px = camera.width_px();
    frame.height_px = camera.height_px();
    const auto pixels =
        static_cast<std::size_t>(frame.width_px) * static_cast<std::size_t>(frame.height_px);
    frame.range_m.assign(pixels, std::numeric_limits<float>::quiet_NaN());
    frame.vehicle.assign(pixels, 0);
    std::vector<float> light(3 * pixels, 0.0F);
    const Eigen::Vector3d eye = map_from_camera.translation();
    const int n = options_.samples;
    for (int v = 0; v < frame.height_px; ++v) {
      for (int u = 0; u < frame.width_px; ++u) {
        const std::size_t at =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.width_px) +
            static_cast<std::size_t>(u);
        const auto centre = camera.Unproject({u, v});
        if (!centre) continue;
        const Hit hit = Cast(eye, map_from_camera.linear() * *centre);
        frame.range_m[at] = static_cast<float>(hit.range_m);
        frame.vehicle[at] = hit.vehicle() ? 1 : 0;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        int seen = 0;
        for (int k = 0; k < n * n; ++k) {
          const auto ray =
              camera.Unproject({u + (k % n + 0.5) / n - 0.5, v + (k / n + 0.5) / n - 0.5});
          if (!ray) continue;
          sum += Colour(eye, map_from_camera.linear() * *ray);
          ++seen;
        }
        if (seen > 0) {
          for (std::size_t i = 0; i < 3; ++i)
            light[3 * at + i] = static_cast<float>(sum[static_cast<int>(i)] / seen);
        }
      }
    }
    Blur(light, frame);
    return WithNoise(light, noise_seed, std::move(frame));
  }

 private:
  struct Box {
    Eigen::Vector3d low, high;
    double contrast = 1.0;
    bool bricks = false;
    std::uint32_t salt = 0;
    std::array<double, 3> colour{};
  };

  static std::uint32_t Hash(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352dU;
    x ^= x >> 15;
    x *= 0x846ca68bU;
    return x ^ (x >> 16);
  }
  static double Lattice(int i, int j, std::uint32_t salt) {
    return static_cast<double>(Hash(static_cast<std::uint32_t>(i) * 0x9E3779B1U ^
                                    Hash(static_cast<std::uint32_t>(j) + salt))) /
               2147483647.5 -
           1.0;
  }
  static double Value(double x, double y, std::uint32_t salt) {
    const double fx = std::floor(x), fy = std::floor(y);
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
    const double a = ease(x - fx), b = ease(y - fy);
    return (Lattice(i, j, salt) * (1 - a) + Lattice(i + 1, j, salt) * a) * (1 - b) +
           (Lattice(i, j + 1, salt) * (1 - a) + Lattice(i + 1, j + 1, salt) * a) * b;
  }

  Eigen::Vector3d Colour(const Eigen::Vector3d& from, const Eigen::Vector3d& along) const {
    const Hit hit = Cast(from, along);
    if (!std::isfinite(hit.range_m)) return {168.0, 190.0, 222.0};
    const Eigen::Vector3d p = from + hit.range_m * along;
    double s = p.x(), t = p.y();
    if (std::abs(hit.normal.x()) > 0.5) s = p.y(), t = p.z();
    if (std::abs(hit.normal.y()) > 0.5) t = p.z();
    const Box* box = hit.box < 0 ? nullptr : &boxes_[static_cast<std::size_t>(hit.box)];
    const std::uint32_t salt = box != nullptr ? box->salt : ground_salt_;
    Eigen::Vector3d colour(96, 94, 90);
    double contrast = 1.0;
    if (box != nullptr) {
      colour = {box->colour[0], box->colour[1], box->colour[2]};
      contrast = box->contrast;
    }
    double size_m = 1.28;
    for (std::uint32_t octave = 0; octave < 7; ++octave, size_m /= 2) {
      if (size_m < 0.4 * hit.range_m / 272.0) break;  // the camera's own limit, as a far wall's
      const double both = Value(s / size_m, t / size_m, salt + 7919U * octave);
      for (std::uint32_t c = 0; c < 3; ++c) {
        const double own = Value(s / size_m, t / size_m, salt + 7919U * octave + 104729U * (c + 1));
        colour[static_cast<int>(c)] += contrast * (9.0 * both + 5.0 * own);
      }
    }
    if (box != nullptr && box->bricks && std::abs(hit.normal.z()) < 0.5) {
      const double row = std::floor(t / 0.25);
      const double along_row = s / 0.5 + 0.5 * (static_cast<int>(row) & 1);
      const double dx = (along_row - std::floor(along_row)) * 0.5, dy = t - 0.25 * row;
      if (dx < 0.02 || dy < 0.02) colour *= 0.72;
      const double wx = s / 2.5 - std::floor(s / 2.5), wy = t / 3.0 - std::floor(t / 3.0);
      if (wx > 0.3 && wx < 0.7 && wy > 0.35 && wy < 0.75)
        colour = 0.45 * colour + Eigen::Vector3d(12, 16, 22);
    }
    return colour * (0.82 + 0.18 * std::abs(hit.normal.z()) + 0.1 * hit.normal.x());
  }

  void Blur(std::vector<float>& light, const Frame& frame) const {
    if (options_.blur_px <= 0) return;
    std::array<float, 5> tap{};
    float sum = 0;
    for (int k = -2; k <= 2; ++k) {
      tap[static_cast<std::size_t>(k + 2)] =
          static_cast<float>(std::exp(-0.5 * k * k / (options_.blur_px * options_.blur_px)));
      sum += tap[static_cast<std::size_t>(k + 2)];
    }
    for (float& t : tap) t /= sum;
    const int w = frame.width_px, h = frame.height_px;
    std::vector<float> other(light.size());
    const auto pass = [&](const std::vector<float>& in, std::vector<float>& out, int du, int dv) {
      for (int v = 0; v < h; ++v) {
        for (int u = 0; u < w; ++u) {
          for (int c = 0; c < 3; ++c) {
            float total = 0;
            for (int k = -2; k <= 2; ++k) {
              const int uu = std::clamp(u + k * du, 0, w - 1),
                        vv = std::clamp(v + k * dv, 0, h - 1);
              total += tap[static_cast<std::size_t>(k + 2)] *
                       in[static_cast<std::size_t>((vv * w + uu) * 3 + c)];
            }
            out[static_cast<std::size_t>((v * w + u) * 3 + c)] = total;
          }
        }
      }
    };
    pass(light, other, 1, 0);
    pass(other, light, 0, 1);
  }

  Frame WithNoise(const std::vector<float>& light, std::uint32_t seed, Frame frame) const {
    frame.rgb.resize(light.size());
    std::mt19937 dice(seed);
    for (std::size_t i = 0; i < light.size(); ++i) {
      // Sum of twelve uniforms: the same on every library, which std::normal_distribution is not.
      double normal = -6.0;
      for (int k = 0; k < 12; ++k) normal += static_cast<double>(dice()) / 4294967295.0;
      const double level = static_cast<double>(light[i]) + options_.noise_levels * normal;
      frame.rgb[i] = static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
    }
    return frame;
  }

  StereoLabOptions options_;
  std::vector<Box> boxes_;
  std::uint32_t ground_salt_ = 0;
};

}  // namespace kawara::test_support
