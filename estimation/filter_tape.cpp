#include "estimation/filter_tape.hpp"

#include <algorithm>

namespace kawara::estimation {

FilterTape::FilterTape(std::size_t steps) : capacity_(steps) {
  steps_.Reserve(steps);
  transitions_.Reserve(steps);
  updates_.Reserve(steps);
  nodes_.Reserve(steps);
}

void FilterTape::Push(const Step& step) {
  steps_.Push(step);
  furthest_ = std::max(furthest_, steps_.end());
}

void FilterTape::Add(const Transition& transition) {
  Push({.kind = Kind::kPropagate, .place = transitions_.Push(transition)});
}

void FilterTape::AddDecay(int first, int count, double factor) {
  Push({.kind = Kind::kDecay,
        .first = static_cast<std::int8_t>(first),
        .count = static_cast<std::int8_t>(count),
        .factor = factor});
}

void FilterTape::AddForget(int first, int count) {
  Push({.kind = Kind::kForget,
        .first = static_cast<std::int8_t>(first),
        .count = static_cast<std::int8_t>(count)});
}

void FilterTape::Add(const Update& update, int rows) {
  Push({.kind = Kind::kUpdate,
        .count = static_cast<std::int8_t>(rows),
        .place = updates_.Push(update)});
}

void FilterTape::Add(const NavKinematics& kinematics, const ErrorCovariance& covariance) {
  Node node{kinematics, covariance.topRows<9>().cast<float>()};
  // The node is for an instant of GNSS time: an error of the time offset is one along the path.
  node.cross.topRows<3>() -=
      (kinematics.velocity_ned_mps * covariance.row(kTimeOffset)).cast<float>();
  Push({.kind = Kind::kNode, .place = nodes_.Push(node)});
}

void FilterTape::Rewind(std::uint64_t position) {
  while (steps_.end() > position) {
    const Step& last = steps_.at(steps_.end() - 1);
    if (last.kind == Kind::kPropagate) transitions_.Rewind(last.place);
    if (last.kind == Kind::kUpdate) updates_.Rewind(last.place);
    if (last.kind == Kind::kNode) nodes_.Rewind(last.place);
    steps_.Rewind(steps_.end() - 1);
  }
}

}  // namespace kawara::estimation
