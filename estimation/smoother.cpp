#include "estimation/smoother.hpp"

#include <Eigen/Core>
#include <cmath>

#include "estimation/rotation.hpp"

namespace kawara::estimation {
namespace {

using Adjoint = ErrorVector;          // lambda
using Information = ErrorCovariance;  // capital lambda

/// x <- F^T x of one column.
void ApplyTransposed(double* x, const Transition& f) {
  using Column = Eigen::Map<Eigen::Vector3d>;
  const Column position(x + kPosition);
  Column velocity(x + kVelocity), attitude(x + kAttitude);
  Column gyro_bias(x + kGyroBias), accel_bias(x + kAccelBias);
  Column gyro_scale(x + kGyroScale), accel_scale(x + kAccelScale);
  const Eigen::Vector3d from_attitude = f.attitude_gyro_bias.transpose() * attitude;
  gyro_bias += from_attitude;
  gyro_scale += f.rate.cwiseProduct(from_attitude);
  Eigen::Map<Eigen::Vector2d>(x + kGyroCross) += f.rate.z() * from_attitude.head<2>();
  const Eigen::Vector3d turned = f.attitude_attitude.transpose() * attitude;
  attitude += turned;
  attitude.noalias() += f.velocity_attitude.transpose() * velocity;
  const Eigen::Vector3d from_velocity = f.velocity_accel_bias.transpose() * velocity;
  accel_bias += from_velocity;
  accel_scale += f.force.cwiseProduct(from_velocity);
  velocity += f.dt_s * position;
}

class Backwards {
 public:
  explicit Backwards(const FilterTape& tape) : tape_(tape) {}

  void Undo(const FilterTape::Step& step) {
    switch (step.kind) {
      case FilterTape::Kind::kPropagate:
        Undo(tape_.transition(step));
        break;
      case FilterTape::Kind::kDecay:
        Scale(step.first, step.count, step.factor);
        break;
      case FilterTape::Kind::kForget:
        Scale(step.first, step.count, 0.0);
        break;
      case FilterTape::Kind::kUpdate:
        Undo(tape_.update(step), step.count);
        break;
      case FilterTape::Kind::kNode:
        break;
    }
  }

  NavSolution SolutionAt(const FilterTape::Node& node) const {
    const Eigen::Matrix<double, 9, kErrorStates> cross = node.cross.cast<double>();
    NavSolution out;
    static_cast<NavKinematics&>(out) = node.kinematics;
    const Eigen::Matrix<double, 9, 1> error = -cross * lambda_;
    out.position = Displaced(out.position, error.segment<3>(kPosition));
    out.velocity_ned_mps += error.segment<3>(kVelocity);
    out.attitude =
        core::AttitudeFromRotation(Rotation(error.segment<3>(kAttitude)).toRotationMatrix() *
                                   core::RotationNedFromBody(node.kinematics.attitude));
    NavCovariance filtered = cross.leftCols<9>();
    filtered.leftCols<3>() -= cross.col(kTimeOffset) * node.kinematics.velocity_ned_mps.transpose();
    const Eigen::Matrix<double, 9, kErrorStates> through = cross.lazyProduct(information_);
    out.covariance = filtered - through.lazyProduct(cross.transpose());
    return out;
  }

 private:
  void Undo(const Transition& f) {
    ApplyTransposed(lambda_.data(), f);
    for (int c = 0; c < kErrorStates; ++c) ApplyTransposed(information_.col(c).data(), f);
    information_.transposeInPlace();
    for (int c = 0; c < kErrorStates; ++c) ApplyTransposed(information_.col(c).data(), f);
  }

  void Scale(int first, int count, double factor) {
    lambda_.segment(first, count) *= factor;
    information_.middleRows(first, count) *= factor;
    information_.middleCols(first, count) *= factor;
  }

  /// lambda <- (I - K H)^T lambda - H^T y,  Lambda <- (I - K H)^T Lambda (I - K H) + H^T H of
  /// whitened rows.
  void Undo(const FilterTape::Update& update, int rows) {
    const auto h = update.h.leftCols(rows);
    const auto gain = update.gain.leftCols(rows);
    lambda_ -= h * (gain.transpose() * lambda_ + update.innovation.head(rows));
    const Eigen::Matrix<double, kErrorStates, Eigen::Dynamic, 0, kErrorStates, 3> through =
        information_.lazyProduct(gain);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> middle =
        gain.transpose().lazyProduct(through);
    middle.diagonal().array() += 1.0;
    // Lambda - h w^T - w h^T + h (K^T Lambda K + I) h^T, in one symmetric sweep.
    const Eigen::Matrix<double, kErrorStates, Eigen::Dynamic, 0, kErrorStates, 3> half =
        through - 0.5 * h * middle;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < kErrorStates; ++c) {
        information_.col(c) -= h.col(r) * half(c, r) + half.col(r) * h(c, r);
      }
    }
  }

  const FilterTape& tape_;
  Adjoint lambda_ = Adjoint::Zero();
  Information information_ = Information::Zero();
};

}  // namespace

void Smooth(const FilterTape& tape, const std::function<bool(const NavSolution&)>& on_node) {
  Backwards backwards(tape);
  for (std::uint64_t position = tape.end(); position > tape.begin(); --position) {
    const FilterTape::Step& step = tape.step(position - 1);
    if (step.kind == FilterTape::Kind::kNode && !on_node(backwards.SolutionAt(tape.node(step)))) {
      return;
    }
    backwards.Undo(step);
  }
}

std::optional<NavSolution> SmoothedAt(const FilterTape& tape, core::GpsTime t) {
  Backwards backwards(tape);
  std::optional<NavSolution> after;
  for (std::uint64_t position = tape.end(); position > tape.begin(); --position) {
    const FilterTape::Step& step = tape.step(position - 1);
    if (step.kind == FilterTape::Kind::kNode) {
      const FilterTape::Node& node = tape.node(step);
      if (node.kinematics.time <= t) {
        const NavSolution before = backwards.SolutionAt(node);
        return after ? std::optional(Interpolated(before, *after, t)) : std::nullopt;
      }
      const bool is_next = [&] {
        for (std::uint64_t p = position - 1; p > tape.begin(); --p) {
          const FilterTape::Step& earlier = tape.step(p - 1);
          if (earlier.kind == FilterTape::Kind::kNode) {
            return tape.node(earlier).kinematics.time <= t;
          }
        }
        return false;
      }();
      if (is_next) after = backwards.SolutionAt(node);
    }
    backwards.Undo(step);
  }
  return std::nullopt;
}

}  // namespace kawara::estimation
