#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <array>
#include <atomic>
#include <cstring>
#include <memory>
#include <vector>

#include "gis/cloud/las_header.hpp"
#include "gis/frame/crs_to_enu.hpp"
#include "gis/gdal_errors.hpp"

namespace kawara::gis {
namespace {

/// A TIFF of one pixel with the keys as its tags: GDAL reads the keys of TIFF files only. Source:
/// TIFF 6.0 section 2 (structure), GeoTIFF 1.1 (OGC 19-008r4) section 7.1 (tags).
class SmallTiff {
 public:
  SmallTiff() {
    Append<std::uint16_t>(0x4949);  // little-endian
    Append<std::uint16_t>(42);
    Append<std::uint32_t>(0);  // where the directory begins: set at the end
    Append<std::uint16_t>(0);  // the pixel, and one to keep what follows on even bytes
  }
  void AddShort(std::uint16_t tag, std::uint16_t value) { entries_.push_back({tag, 3, 1, value}); }
  void AddLong(std::uint16_t tag, std::uint32_t value) { entries_.push_back({tag, 4, 1, value}); }
  void AddBytes(std::uint16_t tag, std::uint16_t type, std::size_t unit, std::string bytes) {
    bytes.resize(bytes.size() / unit * unit);
    if (bytes.empty()) return;
    const auto count = static_cast<std::uint32_t>(bytes.size() / unit);
    bytes.resize(std::max<std::size_t>(bytes.size(), 8), '\0');  // never inside the entry
    if (bytes.size() % 2 == 1) bytes += '\0';
    entries_.push_back({tag, type, count, static_cast<std::uint32_t>(bytes_.size())});
    bytes_ += bytes;
  }
  std::string Finish() {
    const auto directory = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data() + 4, &directory, sizeof(directory));
    Append(static_cast<std::uint16_t>(entries_.size()));
    for (const Entry& e : entries_) {
      Append(e.tag);
      Append(e.type);
      Append(e.count);
      Append(e.value);
    }
    Append<std::uint32_t>(0);
    return std::move(bytes_);
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count, value;
  };
  template <class T>
  void Append(T value) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    bytes_.append(raw.data(), raw.size());
  }
  std::string bytes_;
  std::vector<Entry> entries_;
};

}  // namespace

std::string CrsOfGeoKeys(const std::string& keys, const std::string& doubles,
                         const std::string& text) {
  SmallTiff tiff;
  tiff.AddShort(256, 1);  // width
  tiff.AddShort(257, 1);  // height
  tiff.AddShort(258, 8);  // bits
  tiff.AddShort(259, 1);  // not compressed
  tiff.AddShort(262, 1);  // black is zero
  tiff.AddLong(273, 8);   // where the pixel is
  tiff.AddShort(277, 1);  // one sample
  tiff.AddShort(278, 1);  // rows a strip
  tiff.AddLong(279, 1);   // bytes of the strip
  tiff.AddBytes(34735, 3, 2, keys);
  tiff.AddBytes(34736, 12, 8, doubles);
  tiff.AddBytes(34737, 2, 1, text);
  const std::string bytes = tiff.Finish();

  RegisterGdal();
  const GdalErrorCatcher errors;
  static std::atomic<std::uint64_t> number{0};
  const std::string path = "/vsimem/kawara-las-keys-" + std::to_string(++number) + ".tif";
  // GDAL keeps its own copy, so that nothing of ours need outlive this.
  VSILFILE* file = VSIFOpenL(path.c_str(), "wb");
  if (file == nullptr) return "";
  (void)VSIFWriteL(bytes.data(), 1, bytes.size(), file);
  (void)VSIFCloseL(file);
  std::string wkt;
  const char* const drivers[] = {"GTiff", nullptr};
  if (const std::unique_ptr<GDALDataset> dataset{
          GDALDataset::Open(path.c_str(), GDAL_OF_RASTER, drivers, nullptr, nullptr)}) {
    char* exported = nullptr;
    if (const OGRSpatialReference* crs = dataset->GetSpatialRef();
        crs != nullptr && !crs->IsEmpty() && crs->exportToWkt(&exported) == OGRERR_NONE &&
        exported != nullptr)
      wkt = exported;
    CPLFree(exported);
  }
  VSIUnlink(path.c_str());
  return wkt;
}

}  // namespace kawara::gis
