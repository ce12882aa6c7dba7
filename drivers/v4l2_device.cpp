#include "drivers/v4l2_device.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace kawara::drivers {
namespace {

/// More than any device has; the end of a list that does not end.
constexpr std::uint32_t kMaxListed = 256;

template <std::size_t N>
std::string TextOf(const __u8 (&field)[N]) {
  const char* const text = reinterpret_cast<const char*>(field);
  return {text, strnlen(text, N)};
}

std::string KindOf(std::uint32_t capabilities) {
  if ((capabilities & V4L2_CAP_META_CAPTURE) != 0) return "it delivers metadata";
  if ((capabilities & (V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_VIDEO_OUTPUT_MPLANE)) != 0)
    return "it is an output";
  if ((capabilities & (V4L2_CAP_VIDEO_M2M | V4L2_CAP_VIDEO_M2M_MPLANE)) != 0)
    return "it is a codec";
  if ((capabilities & (V4L2_CAP_VBI_CAPTURE | V4L2_CAP_RADIO | V4L2_CAP_SDR_CAPTURE)) != 0)
    return "it is a radio or teletext receiver";
  return "it does not capture video";
}

bool IsYuvFullRange(std::uint32_t colorspace, std::uint32_t quantization) {
  if (quantization == V4L2_QUANTIZATION_DEFAULT) {
    quantization = V4L2_MAP_QUANTIZATION_DEFAULT(false, colorspace, 0);
  }
  return quantization == V4L2_QUANTIZATION_FULL_RANGE;
}

bool IsBt709(std::uint32_t colorspace, std::uint32_t encoding) {
  if (encoding == V4L2_YCBCR_ENC_DEFAULT) encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(colorspace);
  return encoding == V4L2_YCBCR_ENC_709 || encoding == V4L2_YCBCR_ENC_XV709;
}

V4l2PictureFormat FromSingle(const v4l2_pix_format& f) {
  return {f.pixelformat,
          f.width,
          f.height,
          f.bytesperline,
          f.sizeimage,
          IsYuvFullRange(f.colorspace, f.quantization),
          IsBt709(f.colorspace, f.ycbcr_enc)};
}

V4l2PictureFormat FromMulti(const v4l2_pix_format_mplane& f) {
  return {f.pixelformat,
          f.width,
          f.height,
          f.plane_fmt[0].bytesperline,
          f.plane_fmt[0].sizeimage,
          IsYuvFullRange(f.colorspace, f.quantization),
          IsBt709(f.colorspace, f.ycbcr_enc)};
}

}  // namespace

core::Expected<V4l2Device> V4l2Device::Take(std::string path, std::unique_ptr<V4l2Node> node) {
  V4l2Device device(std::move(path), std::move(node));
  v4l2_capability capability{};
  if (const int error = device.node_->Ioctl(VIDIOC_QUERYCAP, &capability); error != 0) {
    return tl::unexpected(device.Error(VIDIOC_QUERYCAP, error));
  }
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                ? capability.device_caps
                                : capability.capabilities;
  device.identity_ = {TextOf(capability.driver), TextOf(capability.card),
                      TextOf(capability.bus_info)};
  device.multiplanar_ = (can & V4L2_CAP_VIDEO_CAPTURE) == 0;
  if ((can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) == 0) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "camera " + device.path_ + " (" + device.identity_.card +
                          "): not a capture device: " + KindOf(can) +
                          " (`kawara-camera list` shows which are)");
  }
  if ((can & V4L2_CAP_STREAMING) == 0) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "camera " + device.path_ + " (" + device.identity_.card +
                          "): captures, but cannot stream into memory");
  }
  return device;
}

std::uint32_t V4l2Device::buffer_type() const {
  return multiplanar_ ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

core::Expected<std::vector<V4l2FormatOffer>> V4l2Device::Offers() const {
  std::vector<V4l2FormatOffer> offers;
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_fmtdesc format{};
    format.index = i;
    format.type = buffer_type();
    const int error = node_->Ioctl(VIDIOC_ENUM_FMT, &format);
    if (error == EINVAL) break;  // the end of the list
    if (error != 0) return tl::unexpected(Error(VIDIOC_ENUM_FMT, error));
    offers.push_back({format.pixelformat, TextOf(format.description), SizesOf(format.pixelformat)});
  }
  return offers;
}

std::vector<V4l2SizeOffer> V4l2Device::SizesOf(std::uint32_t fourcc) const {
  std::vector<V4l2SizeOffer> sizes;
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = fourcc;
    if (node_->Ioctl(VIDIOC_ENUM_FRAMESIZES, &size) != 0) break;
    V4l2SizeOffer offer;
    if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      offer.min_width = offer.max_width = size.discrete.width;
      offer.min_height = offer.max_height = size.discrete.height;
    } else {
      offer.min_width = size.stepwise.min_width;
      offer.max_width = size.stepwise.max_width;
      offer.step_width = size.stepwise.step_width;
      offer.min_height = size.stepwise.min_height;
      offer.max_height = size.stepwise.max_height;
      offer.step_height = size.stepwise.step_height;
    }
    AddIntervals(fourcc, offer);
    sizes.push_back(std::move(offer));
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) break;  // one entry says it all
  }
  if (!sizes.empty()) return sizes;
  v4l2_format now{};
  now.type = buffer_type();
  if (node_->Ioctl(VIDIOC_G_FMT, &now) != 0) return sizes;
  const V4l2PictureFormat present =
      multiplanar_ ? FromMulti(now.fmt.pix_mp) : FromSingle(now.fmt.pix);
  V4l2SizeOffer offer;
  offer.min_width = offer.max_width = present.width_px;
  offer.min_height = offer.max_height = present.height_px;
  sizes.push_back(std::move(offer));
  return sizes;
}

void V4l2Device::AddIntervals(std::uint32_t fourcc, V4l2SizeOffer& size) const {
  for (std::uint32_t i = 0; i < kMaxListed; ++i) {
    v4l2_frmivalenum interval{};
    interval.index = i;
    interval.pixel_format = fourcc;
    interval.width = size.max_width;
    interval.height = size.max_height;
    if (node_->Ioctl(VIDIOC_ENUM_FRAMEINTERVALS, &interval) != 0) break;
    if (interval.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      size.intervals.push_back({interval.discrete.numerator, interval.discrete.denominator});
      continue;
    }
    size.any_rate_between = true;
    size.intervals.push_back({interval.stepwise.min.numerator, interval.stepwise.min.denominator});
    size.intervals.push_back({interval.stepwise.max.numerator, interval.stepwise.max.denominator});
    break;
  }
  std::erase_if(size.intervals, [](const V4l2Interval& interval) { return !interval.known(); });
  std::sort(size.intervals.begin(), size.intervals.end(),
            [](const V4l2Interval& a, const V4l2Interval& b) { return a.rate_hz() > b.rate_hz(); });
}

core::Expected<V4l2PictureFormat> V4l2Device::SetMode(const V4l2Mode& mode) {
  v4l2_format format{};
  format.type = buffer_type();
  if (multiplanar_) {
    format.fmt.pix_mp.pixelformat = mode.fourcc;
    format.fmt.pix_mp.width = mode.width_px;
    format.fmt.pix_mp.height = mode.height_px;
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
    format.fmt.pix_mp.num_planes = 1;
  } else {
    format.fmt.pix.pixelformat = mode.fourcc;
    format.fmt.pix.width = mode.width_px;
    format.fmt.pix.height = mode.height_px;
    format.fmt.pix.field = V4L2_FIELD_NONE;
  }
  if (const int error = node_->Ioctl(VIDIOC_S_FMT, &format); error != 0) {
    return tl::unexpected(Error(VIDIOC_S_FMT, error));
  }
  const V4l2PictureFormat got =
      multiplanar_ ? FromMulti(format.fmt.pix_mp) : FromSingle(format.fmt.pix);
  const bool planes = multiplanar_ && format.fmt.pix_mp.num_planes != 1;
  if (got.fourcc != mode.fourcc || got.width_px != mode.width_px ||
      got.height_px != mode.height_px || planes) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "camera " + path_ + ": was asked for " + drivers::TextOf(mode) +
                          " and granted " +
                          drivers::TextOf(V4l2Mode{got.fourcc, got.width_px, got.height_px, {}}) +
                          (planes ? " in several planes" : "") + "; choose another mode");
  }
  if (mode.interval.known()) SetInterval(mode.interval);
  return got;
}

void V4l2Device::SetInterval(const V4l2Interval& interval) const {
  v4l2_streamparm parm{};
  parm.type = buffer_type();
  if (node_->Ioctl(VIDIOC_G_PARM, &parm) != 0 ||
      (parm.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) {
    return;  // the device has its one rate
  }
  parm.parm.capture.timeperframe = {interval.numerator, interval.denominator};
  (void)node_->Ioctl(VIDIOC_S_PARM, &parm);  // Interval() tells what came of it
}

V4l2Interval V4l2Device::Interval() const {
  v4l2_streamparm parm{};
  parm.type = buffer_type();
  if (node_->Ioctl(VIDIOC_G_PARM, &parm) != 0) return {};
  const v4l2_fract& period = parm.parm.capture.timeperframe;
  return {period.numerator, period.denominator};
}

}  // namespace kawara::drivers
