#include "onboard/mapper/pair_maker.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::mapper {
namespace {

/// A pair's first stop lies this many behind the newest: its pose has neighbours on both sides.
constexpr std::size_t kLag = 8;
/// Steps and baselines may be this much shorter than asked for, as stops are where they are.
constexpr double kAllowance = 0.85;
/// Of several baselines: shares of the pair's own, behind and ahead. Pictures on both sides at a
/// half and the whole give most of what there is to gain (vision/stereo/multi_matcher.hpp).
constexpr double kOtherBaselines[] = {-1.0, 0.5, -0.5};
/// Keys kept for them behind the one that is paired, at most; the refiner's window has them all.
constexpr std::size_t kMostBehind = 10;
/// Keys before the first that counts, when a run goes on from where another stopped.
constexpr std::size_t kWarmUp = 42;

std::vector<vision::RigCamera> RigOf(
    const Rig& rig, const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras) {
  std::vector<vision::RigCamera> all;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    all.push_back({cameras[i].get(), rig.cameras[i].body_from_camera});
  }
  return all;
}

}  // namespace

PairMaker::PairMaker(const PairOptions& options, const Rig& rig,
                     const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras,
                     std::uint64_t from_stop)
    : options_(options), from_stop_(from_stop), refiner_({}, RigOf(rig, cameras)) {
  for (const auto& camera : rig.cameras) body_from_camera_.push_back(camera.body_from_camera);
}

core::Expected<std::vector<PicturePair>> PairMaker::Add(const Stop& stop) {
  std::vector<PicturePair> pairs;
  const Eigen::Vector3d here = stop.map_from_body.translation();
  if (any_ && (here - last_key_).norm() < std::max(0.01, kAllowance * options_.step_m))
    return pairs;
  any_ = true;
  last_key_ = here;
  if (stop.number < from_stop_) {
    behind_.push_back(stop);
    if (behind_.size() > kWarmUp) behind_.pop_front();
    return pairs;
  }
  for (const Stop& before : behind_) {
    if (auto done = AddKey(before); !done) return tl::unexpected(done.error());
  }
  behind_.clear();
  if (auto done = AddKey(stop); !done) return tl::unexpected(done.error());
  PairUp(options_.refine ? kLag : 0, pairs);
  return pairs;
}

std::vector<PicturePair> PairMaker::Finish() {
  std::vector<PicturePair> pairs;
  // Key by key, so that their pictures are not in memory all at once.
  for (std::size_t lag = std::min(kLag, keys_.size()); pairs.empty() && lag-- > 0;) {
    PairUp(lag, pairs);
  }
  return pairs;
}

core::Expected<void> PairMaker::AddKey(const Stop& stop) {
  Key key{.stop = stop.number,
          .time = stop.time,
          .map_from_body = stop.map_from_body,
          .covariance = stop.covariance.value_or(Eigen::Matrix<double, 6, 6>::Zero()),
          .pictures = {}};
  std::vector<vision::RigPicture> views;
  for (const StopPicture& source : stop.pictures) {
    SharedPicture picture = Load(source);
    if (picture == nullptr) continue;
    views.push_back({source.camera, picture->view()});
    key.pictures.push_back({source, std::move(picture)});
  }
  if (views.empty()) return {};
  if (options_.refine) {
    const vision::PriorPose prior{
        .time = stop.time, .map_from_body = stop.map_from_body, .covariance = stop.covariance};
    if (auto done = refiner_.Add(prior, views); !done) return done;
    // It may be long until this stop's turn comes.
    for (Read& read : key.pictures) read.picture.reset();
  }
  keys_.push_back(std::move(key));
  return {};
}

// Null: it cannot be read, and is counted.
SharedPicture PairMaker::Load(const StopPicture& source) {
  auto picture = source.load();
  if (picture) return std::move(*picture);
  if (unreadable_++ == 0) first_unreadable_ = picture.error().message;
  return nullptr;
}

bool PairMaker::Reload(Read& read) {
  if (read.picture == nullptr) read.picture = Load(read.source);
  return read.picture != nullptr;
}

Eigen::Isometry3d PairMaker::PoseOf(std::size_t key) const {
  return options_.refine ? refiner_.pose(key) : keys_[key - first_key_].map_from_body;
}

vision::StepDoubt PairMaker::DoubtOf(std::size_t a, std::size_t b) const {
  if (options_.refine) return refiner_.Doubt(a, b);
  const Key &key_a = keys_[a - first_key_], &key_b = keys_[b - first_key_];
  const Eigen::Matrix<double, 6, 6> sum = key_a.covariance + key_b.covariance;
  const double length =
      (key_b.map_from_body.translation() - key_a.map_from_body.translation()).norm();
  return {.length_relative_sd = std::sqrt(sum.topLeftCorner<3, 3>().trace() / 3.0) / length,
          .turn_sd_rad = std::sqrt(sum.bottomRightCorner<3, 3>().trace() / 3.0)};
}

double PairMaker::Apart(std::size_t a, std::size_t b) const {
  return (PoseOf(b).translation() - PoseOf(a).translation()).norm();
}

bool PairMaker::IsNear(std::size_t a, std::size_t behind) const {
  return a - behind <= kMostBehind && Apart(a, behind) < 1.5 * options_.baseline_m;
}

std::vector<std::size_t> PairMaker::OthersOf(std::size_t a, std::size_t b) const {
  std::vector<std::size_t> others;
  const std::size_t end = first_key_ + keys_.size();
  for (const double share : kOtherBaselines) {
    const double wanted_m = kAllowance * std::abs(share) * options_.baseline_m;
    std::size_t key = a;
    if (share > 0.0) {
      while (key < end && Apart(a, key) < wanted_m) ++key;
      if (key == end) continue;
    } else {
      while (key > first_key_ && a - key < kMostBehind && Apart(a, key) < wanted_m) --key;
      if (Apart(a, key) < wanted_m || !IsNear(a, key)) continue;
    }
    if (key != b && std::ranges::find(others, key) == others.end()) others.push_back(key);
  }
  return others;
}

void PairMaker::AddMore(std::size_t a, std::size_t b, PicturePair& pair) {
  for (const std::size_t key : OthersOf(a, b)) {
    for (Read& read : keys_[key - first_key_].pictures) {
      if (read.source.camera != pair.camera || !Reload(read)) continue;
      pair.more.push_back({.picture = read.picture,
                           .map_from_camera = PoseOf(key) * body_from_camera_[pair.camera],
                           .doubt = DoubtOf(a, key)});
      break;
    }
  }
}

// Behind the next one to be paired only those that it may yet be matched with stay.
void PairMaker::ForgetKeys() {
  while (first_key_ < next_a_ && !keys_.empty()) {
    const bool to_come = next_a_ == first_key_ + keys_.size();
    if (options_.several && (to_come || IsNear(next_a_, first_key_))) break;
    keys_.pop_front();
    ++first_key_;
  }
}

void PairMaker::PairUp(std::size_t lag, std::vector<PicturePair>& pairs) {
  const std::size_t end = first_key_ + keys_.size();
  for (; next_a_ + lag < end; ++next_a_) {
    const bool warming_up = keys_[next_a_ - first_key_].stop < from_stop_;
    // At every key, so that what is kept depends on the poses alone; the refiner's first ones are
    // gone by the end of its warming up.
    if (!warming_up || !options_.refine) ForgetKeys();
    if (warming_up) continue;
    const Eigen::Isometry3d pose_a = PoseOf(next_a_);
    std::size_t b = next_a_ + 1;
    while (b < end && Apart(next_a_, b) < kAllowance * options_.baseline_m) ++b;
    // Without refinement the second stop may yet have to come.
    if (b == end && lag == 0 && !options_.refine && end - next_a_ <= kLag) break;
    if (b == end || Apart(next_a_, b) > 2.5 * options_.baseline_m) continue;
    Key &key_a = keys_[next_a_ - first_key_], &key_b = keys_[b - first_key_];
    for (Read& first : key_a.pictures) {
      const auto of_same_camera = [&](const Read& read) {
        return read.source.camera == first.source.camera;
      };
      const auto other = std::ranges::find_if(key_b.pictures, of_same_camera);
      if (other == key_b.pictures.end() || !Reload(first) || !Reload(*other)) continue;
      const Eigen::Isometry3d& mounting = body_from_camera_[first.source.camera];
      pairs.push_back({.stop = key_a.stop,
                       .time = key_a.time,
                       .camera = first.source.camera,
                       .name = first.source.name,
                       .picture_a = first.picture,
                       .picture_b = other->picture,
                       .map_from_a = pose_a * mounting,
                       .map_from_b = PoseOf(b) * mounting,
                       .doubt = DoubtOf(next_a_, b),
                       .more = {}});
      if (options_.several) AddMore(next_a_, b, pairs.back());
    }
  }
  ForgetKeys();
}

}  // namespace kawara::mapper
