#pragma once
#include <cstddef>
#include <cstdint>

namespace kawara::vision {

constexpr int kRgbBytes = 3;

/// Somebody else's packed RGB8 picture, rows from the top, `width_px * 3` bytes each, no padding
/// between rows. Does not own the pixels; the owner says how long they live.
struct ConstImageView {
  const std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;

  std::size_t stride_bytes() const { return static_cast<std::size_t>(width_px) * kRgbBytes; }
  std::size_t size_bytes() const { return stride_bytes() * static_cast<std::size_t>(height_px); }
  const std::uint8_t* row(int v) const {
    return data + stride_bytes() * static_cast<std::size_t>(v);
  }
  bool empty() const { return data == nullptr || width_px <= 0 || height_px <= 0; }
};

/// The same, writable.
struct ImageView {
  std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;

  std::size_t stride_bytes() const { return static_cast<std::size_t>(width_px) * kRgbBytes; }
  std::size_t size_bytes() const { return stride_bytes() * static_cast<std::size_t>(height_px); }
  std::uint8_t* row(int v) const { return data + stride_bytes() * static_cast<std::size_t>(v); }
  operator ConstImageView() const {
    return {data, width_px, height_px};
  }  // NOLINT(google-explicit-constructor)
};

}  // namespace kawara::vision
