#pragma once
#include <deque>
#include <memory>
#include <vector>

#include "onboard/mapper/frame_source.hpp"
#include "vision/refine/pose_refiner.hpp"
#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/stereo_camera.hpp"

namespace kawara::mapper {

struct PairOptions {
  double baseline_m = 0.5;  ///< between the two stops of a pair, about
  double step_m = 0.25;     ///< between the first stops of two pairs, about
  bool refine = true;       ///< poses on the pictures; false: as they come
  /// Beside the pair also the picture a baseline behind, and those at half of it on either side.
  bool several = false;
};

/// A picture of the same camera from elsewhere.
struct OtherPicture {
  SharedPicture picture;
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  vision::StepDoubt doubt;  ///< of the step from the pair's first picture
};

/// Two pictures of a camera to make a distance image of the first from.
struct PicturePair {
  std::uint64_t stop = 0;  ///< number of the first one's
  core::GpsTime time;      ///< of the first
  std::size_t camera = 0;
  std::string name;  ///< of the first
  SharedPicture picture_a, picture_b;
  Eigen::Isometry3d map_from_a = Eigen::Isometry3d::Identity();  ///< camera frames
  Eigen::Isometry3d map_from_b = Eigen::Isometry3d::Identity();
  vision::StepDoubt doubt;
  std::vector<OtherPicture> more;  ///< beside picture_b
};

/// From the stops of a drive to pairs of pictures with poses good enough for stereo: of stops a
/// step apart the pictures are read, their poses refined together (vision/refine), and when a stop
/// lies some steps behind it is paired with the next one a baseline on. Which stops those are
/// depends on the poses alone. Pictures are read for the refinement and once more for the pair,
/// which costs less than keeping those of all steps between. One thread.
class PairMaker {
 public:
  /// `cameras`: of the rig, in its order; outlives this. Pairs of stops before `from_stop` are left
  /// out, and their pictures not read but for those the refinement needs to warm up.
  PairMaker(const PairOptions& options, const Rig& rig,
            const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras,
            std::uint64_t from_stop);

  /// Pairs that are ready now. A picture that cannot be read is left out, see unreadable().
  core::Expected<std::vector<PicturePair>> Add(const Stop& stop);
  /// Those still waiting, at the end: at each call those of the next stop; none: that was all.
  std::vector<PicturePair> Finish();

  /// Pictures left out, and the error of the first of them.
  std::uint64_t unreadable() const { return unreadable_; }
  const std::string& first_unreadable() const { return first_unreadable_; }
  /// What was learnt of the rig; empty: poses are not refined.
  const vision::PoseRefiner* refiner() const { return options_.refine ? &refiner_ : nullptr; }

 private:
  struct Read {
    StopPicture source;
    SharedPicture picture;  ///< null: not in memory
  };
  struct Key {
    std::uint64_t stop = 0;
    core::GpsTime time;
    Eigen::Isometry3d map_from_body = Eigen::Isometry3d::Identity();  ///< as it came
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
    std::vector<Read> pictures;
  };

  core::Expected<void> AddKey(const Stop& stop);
  Eigen::Isometry3d PoseOf(std::size_t key) const;
  vision::StepDoubt DoubtOf(std::size_t a, std::size_t b) const;
  double Apart(std::size_t a, std::size_t b) const;
  /// Near enough to be of use to `a` once more.
  bool IsNear(std::size_t a, std::size_t behind) const;
  /// Keys at the other distances, where there are any; `b` is the pair's own.
  std::vector<std::size_t> OthersOf(std::size_t a, std::size_t b) const;
  void AddMore(std::size_t a, std::size_t b, PicturePair& pair);
  void ForgetKeys();
  void PairUp(std::size_t lag, std::vector<PicturePair>& pairs);
  SharedPicture Load(const StopPicture& source);
  bool Reload(Read& read);

  PairOptions options_;
  std::vector<Eigen::Isometry3d> body_from_camera_;
  std::uint64_t from_stop_;
  vision::PoseRefiner refiner_;
  bool any_ = false;
  std::uint64_t unreadable_ = 0;
  std::string first_unreadable_;
  Eigen::Vector3d last_key_ = Eigen::Vector3d::Zero();
  std::deque<Stop> behind_;  ///< keys before from_stop whose pictures may yet be wanted
  std::deque<Key> keys_;
  std::size_t first_key_ = 0;  ///< number of keys_.front(), as the refiner counts
  std::size_t next_a_ = 0;     ///< number of the key that is paired next
};

}  // namespace kawara::mapper
