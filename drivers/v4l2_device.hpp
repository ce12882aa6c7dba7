#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "drivers/v4l2_mode_choice.hpp"
#include "drivers/v4l2_node.hpp"

namespace kawara::drivers {

/// Which camera this is.
struct V4l2Identity {
  std::string driver;    ///< "uvcvideo"
  std::string card;      ///< "HD Pro Webcam C920"
  std::string bus_info;  ///< "usb-0000:00:14.0-1": the socket it is plugged in
  bool operator==(const V4l2Identity&) const = default;
};

/// How the pictures of a stream lie in memory, as the kernel granted it.
struct V4l2PictureFormat {
  std::uint32_t fourcc = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t stride_bytes = 0;  ///< of the first plane; 0: compressed
  std::uint32_t size_bytes = 0;    ///< of a whole picture; compressed: at most
  bool full_range = false;         ///< YCbCr 0..255 (JPEG's), not 16..235
  bool bt709 = false;              ///< YCbCr by BT.709, not BT.601
};

/// An opened capture device: who it is, what it offers, and the format that was set. One thread.
class V4l2Device {
 public:
  /// kInvalidArgument: opens, but does not capture or does not stream (says what it is instead);
  /// kUnavailable: gone meanwhile.
  static core::Expected<V4l2Device> Take(std::string path, std::unique_ptr<V4l2Node> node);

  const std::string& path() const { return path_; }
  const V4l2Identity& identity() const { return identity_; }
  V4l2Node& node() const { return *node_; }
  bool multiplanar() const { return multiplanar_; }
  std::uint32_t buffer_type() const;

  /// Every format, size and rate. A device that lists no sizes (old drivers) offers its present
  /// one.
  core::Expected<std::vector<V4l2FormatOffer>> Offers() const;
  /// Sets format, size and rate. kUnavailable: another program streams from it. kInvalidArgument:
  /// the kernel granted something else than was asked for (and what).
  core::Expected<V4l2PictureFormat> SetMode(const V4l2Mode& mode);
  /// What the device says its frames take now; not known where it does not say.
  V4l2Interval Interval() const;

  core::Error Error(unsigned long request, int errno_value) const {
    return V4l2Error(path_, request, errno_value);
  }

 private:
  V4l2Device(std::string path, std::unique_ptr<V4l2Node> node)
      : path_(std::move(path)), node_(std::move(node)) {}
  std::vector<V4l2SizeOffer> SizesOf(std::uint32_t fourcc) const;
  void AddIntervals(std::uint32_t fourcc, V4l2SizeOffer& size) const;
  void SetInterval(const V4l2Interval& interval) const;

  std::string path_;
  std::unique_ptr<V4l2Node> node_;
  V4l2Identity identity_;
  bool multiplanar_ = false;
};

}  // namespace kawara::drivers
