#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "onboard/survey/picture_file.hpp"
#include "onboard/survey/survey.hpp"

namespace kawara::mapper {

/// What took the pictures, and where the map lies.
struct Rig {
  std::vector<survey::SurveyCamera> cameras;
  std::optional<core::Geodetic> origin;  ///< empty: the map is a frame of its own
};

using SharedPicture = std::shared_ptr<const survey::Picture>;

/// A picture that is read when it is wanted, not before.
struct StopPicture {
  std::size_t camera = 0;  ///< which of the rig
  std::string name;        ///< for people
  std::function<core::Expected<SharedPicture>()> load;
};

/// A moment of the drive: one pose, and the pictures taken then.
struct Stop {
  std::uint64_t number = 0;  ///< in the order of the source, from 0, the same at every run
  core::GpsTime time;
  Eigen::Isometry3d map_from_body = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;  ///< pose_table.hpp
  std::vector<StopPicture> pictures;
};

/// Where the mapper's pictures and poses come from. One thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const Rig& rig() const = 0;
  /// Empty: there are no more.
  virtual core::Expected<std::optional<Stop>> Next() = 0;
  /// Stops in all; 0: nobody knows.
  virtual std::uint64_t total() const { return 0; }
  /// Pictures come whether they can be used or not.
  virtual bool live() const { return false; }
  /// Pictures that were not used because the mapper was late. Any thread.
  virtual std::uint64_t left_out() const { return 0; }
};

}  // namespace kawara::mapper
