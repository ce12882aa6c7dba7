#include <algorithm>
#include <cstring>

#include "gis/cloud/cloud_reader.hpp"
#include "gis/cloud/las_header.hpp"

namespace kawara::gis {
namespace {

/// Where things stand in a record of a point format; 0: not there.
struct Layout {
  std::size_t time = 0, colour = 0;
  bool is_new = false;  ///< formats 6 to 10: flags and classes apart
};
constexpr Layout kLayouts[] = {{0, 0, false},  {20, 0, false},  {0, 20, false}, {20, 28, false},
                               {20, 0, false}, {20, 28, false}, {22, 0, true},  {22, 30, true},
                               {22, 30, true}, {22, 0, true},   {22, 30, true}};
// Colours are of 16 bits, yet some writers put bytes there. Which, the first points tell.
constexpr std::uint64_t kPointsToJudgeColours = 4096;

template <class T>
T At(const std::uint8_t* bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes + offset, sizeof(T));
  return value;
}

class LasReader : public CloudReader {
 public:
  explicit LasReader(ByteSource source) : CloudReader(std::move(source)) {}
  core::Expected<void> Start();

 protected:
  void Fill(std::size_t most) override;

 private:
  void JudgeColours();
  LasHeader header_;
  Layout layout_;
  std::uint32_t colour_divisor_ = 1;
};

void LasReader::JudgeColours() {
  if (layout_.colour == 0 || !source_.Seek(header_.points_at)) return;
  for (std::uint64_t i = 0; i < std::min(header_.points, kPointsToJudgeColours); ++i) {
    const auto bytes = source_.Peek(header_.record_bytes);
    if (bytes.size() < header_.record_bytes) return;
    for (std::size_t k = 0; k < 3; ++k)
      if (At<std::uint16_t>(bytes.data(), layout_.colour + 2 * k) > 255) colour_divisor_ = 257;
    source_.Take(header_.record_bytes);
  }
}

core::Expected<void> LasReader::Start() {
  auto header = ReadLasHeader(source_);
  if (!header) return tl::unexpected(header.error());
  header_ = std::move(*header);
  layout_ = kLayouts[header_.format];
  info_.format = CloudFormat::kLas;
  info_.promised = left_ = header_.points;
  info_.has_colour = layout_.colour != 0;
  info_.has_intensity = true;
  info_.has_time = layout_.time != 0;
  info_.crs = header_.crs;
  if (header_.low.allFinite() && header_.high.allFinite())
    info_.bounds = {header_.low, header_.high};
  JudgeColours();
  if (left_ > 0 && !source_.Seek(header_.points_at)) {
    FailAtEnd();
    return tl::unexpected(*error_);
  }
  return {};
}

void LasReader::Fill(std::size_t most) {
  for (std::size_t i = 0; i < most && left_ > 0; ++i) {
    const auto bytes = source_.Peek(header_.record_bytes);
    if (bytes.size() < header_.record_bytes) {
      FailAtEnd();
      return;
    }
    const std::uint8_t* record = bytes.data();
    CloudPoint point;
    for (Eigen::Index k = 0; k < 3; ++k)
      point.position[k] =
          At<std::int32_t>(record, 4 * static_cast<std::size_t>(k)) * header_.scale[k] +
          header_.offset[k];
    point.intensity = At<std::uint16_t>(record, 12);
    const std::uint8_t flags = record[15];
    const bool is_withheld = (flags & (layout_.is_new ? 0x04U : 0x80U)) != 0;
    point.classification = layout_.is_new ? record[16] : flags & 0x1FU;
    if (layout_.time != 0) point.time_s = At<double>(record, layout_.time);
    if (layout_.colour != 0) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t value = At<std::uint16_t>(record, layout_.colour + 2 * k);
        point.colour[k] = static_cast<std::uint8_t>(
            std::min<std::uint32_t>((value + colour_divisor_ / 2) / colour_divisor_, 255));
      }
    }
    source_.Take(header_.record_bytes);
    --left_;
    if (is_withheld) {
      ++info_.withheld;
    } else {
      Keep(point);
    }
  }
}

}  // namespace

core::Expected<CloudReaderPtr> OpenLas(ByteSource source) {
  auto reader = std::make_unique<LasReader>(std::move(source));
  if (auto started = reader->Start(); !started) return tl::unexpected(started.error());
  return reader;
}

}  // namespace kawara::gis
