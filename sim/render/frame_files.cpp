#include "sim/render/frame_files.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "vision/jpeg.hpp"

namespace kawara::sim {
namespace {

core::Expected<void> WriteBytes(const std::filesystem::path& path, const char* data,
                                std::size_t size) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(data, static_cast<std::streamsize>(size));
  file.close();
  if (!file) return tl::unexpected(core::ErrnoError("write " + path.string(), errno));
  return {};
}

core::Expected<void> WritePng(const cv::Mat& image, const std::filesystem::path& path) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3})) {
    return core::Fail(core::ErrorCode::kIo, "write " + path.string() + ": cannot compress as PNG");
  }
  return WriteBytes(path, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

template <class Value>
core::Expected<void> WriteWords(const RenderedFrame& frame, const std::filesystem::path& path,
                                const Value& value) {
  cv::Mat words(frame.height_px, frame.width_px, CV_16UC1);
  for (int v = 0; v < frame.height_px; ++v) {
    for (int u = 0; u < frame.width_px; ++u) {
      words.at<std::uint16_t>(v, u) =
          value(static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.width_px) +
                static_cast<std::size_t>(u));
    }
  }
  return WritePng(words, path);
}

}  // namespace

core::Expected<void> WriteColour(const RenderedFrame& frame, const std::filesystem::path& jpeg,
                                 int quality) {
  vision::JpegEncoder encoder;
  const auto bytes = encoder.Encode(frame.view(), {.quality = quality, .progressive = false});
  if (!bytes) return tl::unexpected(bytes.error());
  return WriteBytes(jpeg, reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

core::Expected<void> WriteColourPng(const RenderedFrame& frame, const std::filesystem::path& png) {
  cv::Mat bgr(frame.height_px, frame.width_px, CV_8UC3);
  for (int v = 0; v < frame.height_px; ++v) {
    const std::uint8_t* from = frame.view().row(v);
    for (int u = 0; u < frame.width_px; ++u, from += 3) {
      bgr.at<cv::Vec3b>(v, u) = {from[2], from[1], from[0]};
    }
  }
  return WritePng(bgr, png);
}

core::Expected<void> WriteRangePfm(const RenderedFrame& frame, const std::filesystem::path& pfm) {
  static_assert(std::endian::native == std::endian::little);
  const std::string header =
      "Pf\n" + std::to_string(frame.width_px) + " " + std::to_string(frame.height_px) + "\n-1.0\n";
  const std::size_t row_bytes = static_cast<std::size_t>(frame.width_px) * sizeof(float);
  std::string bytes = header;
  bytes.reserve(header.size() + row_bytes * static_cast<std::size_t>(frame.height_px));
  for (int v = frame.height_px - 1; v >= 0; --v) {
    const float* row =
        &frame.range_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.width_px)];
    bytes.append(reinterpret_cast<const char*>(row), row_bytes);
  }
  return WriteBytes(pfm, bytes.data(), bytes.size());
}

core::Expected<void> WriteRangePng(const RenderedFrame& frame, const std::filesystem::path& png) {
  return WriteWords(frame, png, [&](std::size_t i) {
    const float range = frame.range_m[i];
    if (std::isnan(range)) return std::uint16_t{0};
    return static_cast<std::uint16_t>(std::lround(std::clamp(1000.0F * range, 1.0F, 65535.0F)));
  });
}

core::Expected<void> WriteObjectsPng(const RenderedFrame& frame, const std::filesystem::path& png) {
  return WriteWords(frame, png, [&](std::size_t i) {
    return static_cast<std::uint16_t>(std::min(frame.object[i], 65535U));
  });
}

}  // namespace kawara::sim
