#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "estimation/error_state.hpp"
#include "estimation/nav_types.hpp"

namespace kawara::estimation {

/// The transition of the errors over one step, I + A dt, as its blocks that are not I or 0.
struct Transition {
  double dt_s = 0.0;
  Eigen::Matrix3d velocity_attitude;  ///< all including dt
  Eigen::Matrix3d velocity_accel_bias;
  Eigen::Matrix3d attitude_attitude;  ///< minus I
  Eigen::Matrix3d attitude_gyro_bias;
  Eigen::Vector3d force;  ///< columns of the scale blocks: those of the bias times these
  Eigen::Vector3d rate;
};

/// What the filter did, step by step, so that a smoother can go back over it. Errors of a step are
/// those after the steps before it; an update is kept whitened, as `rows` independent unit-variance
/// innovations.
///
/// A growing tape takes about 2 KB an inertial sample. A ring keeps the newest steps within fixed
/// memory and allocates only when made. One thread.
class FilterTape {
 public:
  enum class Kind : std::uint8_t { kPropagate, kDecay, kForget, kUpdate, kNode };

  struct Step {
    Kind kind = Kind::kNode;
    std::int8_t first = 0;    ///< error index of kDecay, kForget
    std::int8_t count = 0;    ///< errors of kDecay, kForget; rows of kUpdate
    double factor = 1.0;      ///< of kDecay
    std::uint64_t place = 0;  ///< of what else belongs to it
  };

  struct Update {
    Eigen::Matrix<double, kErrorStates, 3>
        h;  ///< transposed, whitened; columns beyond `rows` are 0
    Eigen::Matrix<double, kErrorStates, 3> gain;
    Eigen::Vector3d innovation;
  };
  /// Where the smoother may hand out a solution.
  struct Node {
    NavKinematics kinematics;
    /// Covariance of position, velocity, attitude with all errors. Float: 1e-7 of itself.
    Eigen::Matrix<float, 9, kErrorStates> cross;
  };

  /// Grows.
  FilterTape() = default;
  /// Keeps the newest `steps` steps. 75 Hz, GNSS at 10 Hz and wheels at 20 Hz make about 250 a
  /// second.
  explicit FilterTape(std::size_t steps);

  void Add(const Transition& transition);
  /// Errors first..first+2 (or one) shrink by `factor` of their own.
  void AddDecay(int first, int count, double factor);
  /// Errors first..first+count-1 begin anew, independent of everything.
  void AddForget(int first, int count);
  void Add(const Update& update, int rows);
  void Add(const NavKinematics& kinematics, const ErrorCovariance& covariance);

  /// Steps ever written; a position to go back to with Rewind.
  std::uint64_t end() const { return steps_.end(); }
  /// The oldest step still there.
  std::uint64_t begin() const {
    return furthest_ > capacity_ && capacity_ > 0 ? furthest_ - capacity_ : 0;
  }
  /// Forgets everything from `position` on.
  void Rewind(std::uint64_t position);

  const Step& step(std::uint64_t position) const { return steps_.at(position); }
  const Transition& transition(const Step& s) const { return transitions_.at(s.place); }
  const Update& update(const Step& s) const { return updates_.at(s.place); }
  const Node& node(const Step& s) const { return nodes_.at(s.place); }

 private:
  /// Items by their place since the start of time, in chunks so that growing never moves them. With
  /// a capacity the newest so many are there.
  template <class T>
  class Track {
   public:
    void Reserve(std::size_t capacity) {
      capacity_ = capacity;
      while (chunks_.size() * kChunk < capacity) AddChunk();
    }
    std::uint64_t Push(const T& item) {
      const std::uint64_t slot = SlotOf(end_);
      if (slot / kChunk == chunks_.size()) AddChunk();
      chunks_[slot / kChunk][slot % kChunk] = item;
      return end_++;
    }
    const T& at(std::uint64_t place) const {
      const std::uint64_t slot = SlotOf(place);
      return chunks_[slot / kChunk][slot % kChunk];
    }
    void Rewind(std::uint64_t end) { end_ = end; }
    std::uint64_t end() const { return end_; }

   private:
    static constexpr std::uint64_t kChunk = 1024;

    std::uint64_t SlotOf(std::uint64_t place) const {
      return capacity_ > 0 ? place % capacity_ : place;
    }
    void AddChunk() { chunks_.push_back(std::make_unique<T[]>(kChunk)); }

    std::vector<std::unique_ptr<T[]>> chunks_;
    std::size_t capacity_ = 0;
    std::uint64_t end_ = 0;
  };

  void Push(const Step& step);

  Track<Step> steps_;
  Track<Transition> transitions_;
  Track<Update> updates_;
  Track<Node> nodes_;
  std::size_t capacity_ = 0;    ///< 0: grows
  std::uint64_t furthest_ = 0;  ///< the most steps there ever were; a Rewind does not lessen it
};

}  // namespace kawara::estimation
