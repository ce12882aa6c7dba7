#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "gis/model/model_writers.hpp"
#include "gis/model/text.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {
namespace {

static_assert(std::endian::native == std::endian::little);

// Khronos glTF 2.0: 5.1.3 (component types), 5.11 (targets), 4.4 (GLB).
constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kArrayBuffer = 34962;
constexpr int kElementBuffer = 34963;
constexpr std::uint32_t kGlbMagic = 0x46546C67;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

/// Grows the binary chunk and what the JSON says about it.
class Buffers {
 public:
  /// Returns the view's number. `target` 0: none (a picture).
  int AddView(const void* data, std::size_t bytes, int target, int stride = 0) {
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    Comma(views_);
    views_ += "{\"buffer\":0,\"byteOffset\":" + std::to_string(binary_.size()) +
              ",\"byteLength\":" + std::to_string(bytes);
    if (stride > 0) views_ += ",\"byteStride\":" + std::to_string(stride);
    if (target != 0) views_ += ",\"target\":" + std::to_string(target);
    views_ += "}";
    binary_.append(static_cast<const char*>(data), bytes);
    return view_count_++;
  }
  int AddAccessor(int view, int type, std::size_t count, const char* shape,
                  const std::string& more = "") {
    Comma(accessors_);
    accessors_ +=
        "{\"bufferView\":" + std::to_string(view) + ",\"componentType\":" + std::to_string(type) +
        ",\"count\":" + std::to_string(count) + ",\"type\":\"" + shape + "\"" + more + "}";
    return accessor_count_++;
  }
  const std::string& views() const { return views_; }
  const std::string& accessors() const { return accessors_; }
  std::string& binary() { return binary_; }

  static void Comma(std::string& list) {
    if (!list.empty()) list += ",";
  }

 private:
  std::string views_, accessors_, binary_;
  int view_count_ = 0, accessor_count_ = 0;
};

template <std::size_t N, class Rows>
std::string MinMax(const Rows& rows) {
  std::array<float, N> low = rows.front(), high = rows.front();
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < N; ++i) {
      low[i] = std::min(low[i], row[i]);
      high[i] = std::max(high[i], row[i]);
    }
  }
  const auto list = [](const std::array<float, N>& values) {
    std::string text;
    for (const float v : values) {
      Buffers::Comma(text);
      AppendNumber(text, static_cast<double>(v), 9);
    }
    return "[" + text + "]";
  };
  return ",\"min\":" + list(low) + ",\"max\":" + list(high);
}

struct Lists {
  std::string nodes, meshes, materials, textures, images;
  int count = 0, textured = 0;
};

// sRGB of the picture to the linear light glTF wants in COLOR_0 (8 bits of it are enough for
// colours that stand where no texture is).
std::uint8_t LinearFromSrgb(std::uint8_t srgb) {
  const double s = srgb / 255.0;
  const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<std::uint8_t>(std::lround(255.0 * linear));
}

void AddMesh(const core::TexturedMesh& mesh, Buffers& buffers, Lists& lists) {
  const std::size_t n = mesh.positions_m.size();
  const auto rows = [&](const auto& values, const char* shape, const std::string& more) {
    const int view =
        buffers.AddView(values.data(), values.size() * sizeof(values[0]), kArrayBuffer);
    return std::to_string(buffers.AddAccessor(view, kFloat, n, shape, more));
  };
  std::string attributes =
      "\"POSITION\":" + rows(mesh.positions_m, "VEC3", MinMax<3>(mesh.positions_m));
  if (!mesh.normals.empty()) attributes += ",\"NORMAL\":" + rows(mesh.normals, "VEC3", "");
  const bool textured = !mesh.texture_jpeg.empty();
  if (textured) {
    attributes += ",\"TEXCOORD_0\":" + rows(mesh.texture_coordinates, "VEC2", "");
  } else if (!mesh.colours.empty()) {
    std::vector<std::array<std::uint8_t, 4>> padded(n);  // rows must begin at multiples of four
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < 3; ++c) padded[i][c] = LinearFromSrgb(mesh.colours[i][c]);
      padded[i][3] = 255;
    }
    const int view = buffers.AddView(padded.data(), 4 * n, kArrayBuffer);
    attributes += ",\"COLOR_0\":" + std::to_string(buffers.AddAccessor(
                                        view, kUnsignedByte, n, "VEC4", ",\"normalized\":true"));
  }
  const int index_view =
      buffers.AddView(mesh.triangles.data(), mesh.triangles.size() * 12, kElementBuffer);
  const int indices =
      buffers.AddAccessor(index_view, kUnsignedInt, mesh.triangles.size() * 3, "SCALAR");

  Buffers::Comma(lists.materials);
  lists.materials += "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":1";
  if (textured) {
    const int view = buffers.AddView(mesh.texture_jpeg.data(), mesh.texture_jpeg.size(), 0);
    Buffers::Comma(lists.images);
    lists.images += "{\"mimeType\":\"image/jpeg\",\"bufferView\":" + std::to_string(view) + "}";
    Buffers::Comma(lists.textures);
    lists.textures += "{\"source\":" + std::to_string(lists.textured) + "}";
    lists.materials += ",\"baseColorTexture\":{\"index\":" + std::to_string(lists.textured++) + "}";
  }
  lists.materials += "},\"doubleSided\":true,\"extensions\":{\"KHR_materials_unlit\":{}}}";
  Buffers::Comma(lists.meshes);
  lists.meshes += "{\"name\":\"" + mesh.name + "\",\"primitives\":[{\"attributes\":{" + attributes +
                  "},\"indices\":" + std::to_string(indices) +
                  ",\"material\":" + std::to_string(lists.count) + "}]}";
  Buffers::Comma(lists.nodes);
  lists.nodes += "{\"name\":\"" + mesh.name + "\",\"mesh\":" + std::to_string(lists.count) +
                 ",\"translation\":[" + Number(mesh.offset_m.x(), 6) + "," +
                 Number(mesh.offset_m.y(), 6) + "," + Number(mesh.offset_m.z(), 6) +
                 "],\"extras\":{\"revision\":" + std::to_string(mesh.revision) + "}}";
  ++lists.count;
}

std::string JsonOf(const Lists& lists, const Buffers& buffers, std::size_t binary_bytes,
                   const core::Geodetic& origin) {
  std::string json =
      "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Kawaraban\",\"extras\":{\"origin\":\"" +
      OriginText(origin) + "\"}},";
  // Pictures have their own light.
  if (lists.count > 0) json += "\"extensionsUsed\":[\"KHR_materials_unlit\"],";
  json += "\"scene\":0,\"scenes\":[{\"nodes\":[" + std::to_string(lists.count) + "]}],\"nodes\":[" +
          lists.nodes;
  if (lists.count > 0) json += ",";
  // The last node is the root: -90 degrees about X take up to Y and north to -Z.
  json += "{\"name\":\"map\",\"rotation\":[-0.70710678118654757,0,0,0.70710678118654757]";
  if (lists.count > 0) {
    std::string children;
    for (int i = 0; i < lists.count; ++i) {
      Buffers::Comma(children);
      children += std::to_string(i);
    }
    json += ",\"children\":[" + children + "]}],\"meshes\":[" + lists.meshes + "],\"materials\":[" +
            lists.materials + "]";
    if (lists.textured > 0)
      json += ",\"textures\":[" + lists.textures + "],\"images\":[" + lists.images + "]";
    json += ",\"accessors\":[" + buffers.accessors() + "],\"bufferViews\":[" + buffers.views() +
            "],\"buffers\":[{\"byteLength\":" + std::to_string(binary_bytes) + "}]}";
  } else {
    json += "}]}";
  }
  return json;
}

}  // namespace

core::Expected<void> WriteGlb(const std::filesystem::path& path,
                              std::span<const core::TexturedMesh> meshes,
                              const core::Geodetic& origin) {
  Buffers buffers;
  Lists lists;
  for (const auto& mesh : meshes) {
    if (auto good = CheckMesh(mesh); !good) return good;
    if (!mesh.triangles.empty()) AddMesh(mesh, buffers, lists);
  }
  std::string& binary = buffers.binary();
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string json = JsonOf(lists, buffers, binary.size(), origin);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t total = 12 + 8 + json.size() + (binary.empty() ? 0 : 8 + binary.size());
  if (total > 0xFFFFFFFFU)
    return core::Fail(core::ErrorCode::kFull, path.string() + ": a GLB holds at most 4 GB");
  std::string file;
  file.reserve(total);
  for (const std::uint32_t word : {kGlbMagic, 2U, static_cast<std::uint32_t>(total),
                                   static_cast<std::uint32_t>(json.size()), kJsonChunk})
    AppendBytes(file, word);
  file += json;
  if (!binary.empty()) {
    AppendBytes(file, static_cast<std::uint32_t>(binary.size()));
    AppendBytes(file, kBinaryChunk);
    file += binary;
  }
  return WriteWholeFile(path, file);
}

}  // namespace kawara::gis
