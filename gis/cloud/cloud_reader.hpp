#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gis/cloud/byte_source.hpp"
#include "gis/cloud/cloud.hpp"

namespace kawara::gis {

/// A cloud that is pulled out of its file: what ReadCloud and ReadCloudEnu are made of.
class CloudReader {
 public:
  virtual ~CloudReader() = default;
  const CloudInfo& info() const { return info_; }

  /// The next points; empty: that was all. An error that comes in the middle of a chunk is told
  /// after the points before it. Valid until the next call.
  core::Expected<std::span<const CloudPoint>> Next(std::size_t most_points) {
    chunk_.clear();
    while (!error_ && chunk_.empty() && left_ > 0) Fill(most_points);
    if (error_ && chunk_.empty()) return tl::unexpected(*error_);
    info_.delivered += chunk_.size();
    return chunk_;
  }

 protected:
  explicit CloudReader(ByteSource source) : source_(std::move(source)) {}
  /// Up to `most` points from the file, counted off left_, into Keep; or error_.
  virtual void Fill(std::size_t most) = 0;

  void Keep(const CloudPoint& point) {
    if (point.position.allFinite()) {
      chunk_.push_back(point);
    } else {
      ++info_.not_finite;
    }
  }
  void FailAtEnd() {
    error_ = core::Error{core::ErrorCode::kFormat,
                         source_.name() + ": ends after " + std::to_string(info_.promised - left_) +
                             " of " + std::to_string(info_.promised) + " points, at byte " +
                             std::to_string(source_.size()) + " (cut off? copy it again)"};
  }

  ByteSource source_;
  CloudInfo info_;
  std::uint64_t left_ = 0;  ///< points of the file not looked at yet
  std::vector<CloudPoint> chunk_;
  std::optional<core::Error> error_;
};

using CloudReaderPtr = std::unique_ptr<CloudReader>;
core::Expected<CloudReaderPtr> OpenPly(ByteSource source);
core::Expected<CloudReaderPtr> OpenLas(ByteSource source);
/// By the first bytes.
core::Expected<CloudReaderPtr> OpenCloud(ByteSource source);

}  // namespace kawara::gis
