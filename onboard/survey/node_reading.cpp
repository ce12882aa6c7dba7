#include "onboard/survey/node_reading.hpp"

#include <Eigen/SVD>
#include <charconv>
#include <cmath>

namespace kawara::survey {
namespace {

constexpr std::size_t kMostNumbers = 4096;

core::Expected<void> Collect(const Node& node, std::vector<double>& numbers) {
  if (node.kind == Node::Kind::kMap) {
    const auto data = Need(node, "data");
    if (!data) return tl::unexpected(data.error());
    return Collect(**data, numbers);
  }
  if (node.kind == Node::Kind::kScalar) {
    const auto number = NumberOf(node);
    if (!number) return tl::unexpected(number.error());
    if (numbers.size() >= kMostNumbers) return Wrong(node, "too many numbers");
    numbers.push_back(*number);
    return {};
  }
  if (node.kind != Node::Kind::kSequence) return Wrong(node, "expected numbers");
  for (const Node& item : node.items) {
    if (auto done = Collect(item, numbers); !done) return done;
  }
  return {};
}

}  // namespace

tl::unexpected<core::Error> Wrong(const Node& node, const std::string& what) {
  const core::config::Place& place = node.place;
  return core::Fail(core::ErrorCode::kFormat, place.source + ":" + std::to_string(place.line) +
                                                  ":" + std::to_string(place.column) + ": " + what);
}

core::Expected<const Node*> Need(const Node& map, std::string_view key) {
  const Node* node = map.kind == Node::Kind::kMap ? map.Find(key) : nullptr;
  if (node == nullptr) return Wrong(map, std::string(key) + ": missing");
  return node;
}

core::Expected<double> NumberOf(const Node& node) {
  std::string_view text = node.text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole =
      error == std::errc() &&
      (end == text.data() + text.size() || std::string_view(end, text.data() + text.size()) == ".");
  if (node.kind != Node::Kind::kScalar || !whole || !std::isfinite(value)) {
    return Wrong(node, node.Shown() + ": expected a number");
  }
  return value;
}

core::Expected<double> NeedNumber(const Node& map, std::string_view key) {
  const auto node = Need(map, key);
  if (!node) return tl::unexpected(node.error());
  return NumberOf(**node);
}

core::Expected<std::vector<double>> NumbersOf(const Node& node, std::size_t count) {
  std::vector<double> numbers;
  if (auto done = Collect(node, numbers); !done) return tl::unexpected(done.error());
  if (count != 0 && numbers.size() != count) {
    return Wrong(node, "expected " + std::to_string(count) + " numbers, found " +
                           std::to_string(numbers.size()));
  }
  return numbers;
}

core::Expected<std::vector<double>> NeedNumbers(const Node& map, std::string_view key,
                                                std::size_t count) {
  const auto node = Need(map, key);
  if (!node) return tl::unexpected(node.error());
  return NumbersOf(**node, count);
}

core::Expected<Eigen::Isometry3d> TransformOf(const std::vector<double>& rows, const Node& where) {
  if (rows.size() != 16) return Wrong(where, "expected a 4 x 4 matrix");
  const Eigen::Matrix4d given =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data());
  const Eigen::Matrix3d R = given.topLeftCorner<3, 3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  const bool last_row = (given.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < 1e-6;
  if (!((nearest - R).norm() < 1e-3) || !(nearest.determinant() > 0.0) || !last_row ||
      !given.allFinite()) {
    return Wrong(where, "expected a rigid transform: a rotation, a translation, 0 0 0 1");
  }
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = nearest;
  transform.translation() = given.topRightCorner<3, 1>();
  return transform;
}

core::Expected<Eigen::Quaterniond> QuaternionOf(double w, double x, double y, double z) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (!(std::abs(q.norm() - 1.0) < 1e-2)) {
    return core::Fail(core::ErrorCode::kFormat,
                      "quaternion of length " + std::to_string(q.norm()) + ": expected 1");
  }
  return q.normalized();
}

}  // namespace kawara::survey
