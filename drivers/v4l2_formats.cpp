#include "drivers/v4l2_formats.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cstdio>

namespace kawara::drivers {
namespace {

constexpr std::array<V4l2PixelFormat, 9> kFormats{{
    {V4L2_PIX_FMT_MJPEG, "MJPG", V4l2Layout::kMotionJpeg},
    {V4L2_PIX_FMT_JPEG, "JPEG", V4l2Layout::kMotionJpeg},
    {V4L2_PIX_FMT_NV12, "NV12", V4l2Layout::kNv12},
    {V4L2_PIX_FMT_YUYV, "YUYV", V4l2Layout::kYuyv},
    {V4L2_PIX_FMT_SRGGB8, "RGGB", V4l2Layout::kBayer},
    {V4L2_PIX_FMT_SBGGR8, "BGGR", V4l2Layout::kBayer},
    {V4L2_PIX_FMT_SGBRG8, "GBRG", V4l2Layout::kBayer},
    {V4L2_PIX_FMT_SGRBG8, "GRBG", V4l2Layout::kBayer},
    {V4L2_PIX_FMT_GREY, "GREY", V4l2Layout::kGrey},
}};

bool OnRaster(std::uint32_t value, std::uint32_t min, std::uint32_t max, std::uint32_t step) {
  return value >= min && value <= max && (step <= 1 || (value - min) % step == 0);
}

std::string RateText(double rate_hz) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", rate_hz);
  return text;
}

}  // namespace

std::span<const V4l2PixelFormat> V4l2PixelFormats() { return kFormats; }

const V4l2PixelFormat* FindV4l2PixelFormat(std::uint32_t fourcc) {
  for (const V4l2PixelFormat& format : kFormats) {
    if (format.fourcc == fourcc) return &format;
  }
  return nullptr;
}

const V4l2PixelFormat* FindV4l2PixelFormat(std::string_view name) {
  for (const V4l2PixelFormat& format : kFormats) {
    if (name == format.name) return &format;
  }
  return nullptr;
}

std::string V4l2PixelFormatNames() {
  std::string names;
  for (const V4l2PixelFormat& format : kFormats) {
    names += (names.empty() ? "" : " ") + std::string(format.name);
  }
  return names;
}

std::string FourccText(std::uint32_t fourcc) {
  if (const V4l2PixelFormat* const known = FindV4l2PixelFormat(fourcc)) return known->name;
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>((fourcc >> (8 * i)) & 0x7FU);
    text += c >= ' ' && c <= '~' ? c : '.';
  }
  return text;
}

bool V4l2SizeOffer::Has(std::uint32_t width, std::uint32_t height) const {
  return OnRaster(width, min_width, max_width, step_width) &&
         OnRaster(height, min_height, max_height, step_height);
}

std::string SizeText(const V4l2SizeOffer& size) {
  const auto text = [](std::uint32_t w, std::uint32_t h) {
    return std::to_string(w) + "x" + std::to_string(h);
  };
  if (size.min_width == size.max_width && size.min_height == size.max_height) {
    return text(size.max_width, size.max_height);
  }
  return text(size.min_width, size.min_height) + ".." + text(size.max_width, size.max_height) +
         " in steps of " + text(size.step_width, size.step_height);
}

std::string RatesText(const V4l2SizeOffer& size) {
  if (size.intervals.empty()) return "?";
  if (size.any_rate_between) {
    return RateText(size.intervals.back().rate_hz()) + ".." +
           RateText(size.intervals.front().rate_hz());
  }
  std::string text;
  for (const V4l2Interval& interval : size.intervals) {
    text += (text.empty() ? "" : " ") + RateText(interval.rate_hz());
  }
  return text;
}

std::string TextOf(const std::vector<V4l2FormatOffer>& offers, std::size_t max_sizes) {
  std::string text;
  for (const V4l2FormatOffer& offer : offers) {
    text += (text.empty() ? "" : "; ") + FourccText(offer.fourcc);
    for (std::size_t i = 0; i < offer.sizes.size() && i < max_sizes; ++i) {
      text += (i == 0 ? " " : ", ") + SizeText(offer.sizes[i]) + " at " +
              RatesText(offer.sizes[i]) + " Hz";
    }
    if (offer.sizes.size() > max_sizes) {
      text += ", and " + std::to_string(offer.sizes.size() - max_sizes) + " sizes more";
    }
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace kawara::drivers
