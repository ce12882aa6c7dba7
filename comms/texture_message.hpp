#pragma once
#include <cstdint>
#include <kawara/object_texture_t.hpp>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/object_textures.hpp"

namespace kawara::comms {

/// Bytes of the atlas in a message at most: with names and faces it still is one packet.
constexpr std::size_t kTexturePartBytes = 900;

/// The sides of an object's revision with what a receiver must know to place them.
struct TextureReport {
  std::string robot;
  std::string mission;
  std::string uid;
  std::uint64_t revision = 0;
  core::ObjectTextures textures;
};

/// The parts of an atlas. Errors: kInvalidArgument: no atlas, or one beyond
/// TextureAssembler::kMaxAtlasBytes.
[[nodiscard]] core::Expected<std::vector<object_texture_t>> ToMessages(const TextureReport& report);

/// Parts to atlases, in any order, some twice, some never. Keeps the newest few that are not whole.
/// One thread.
class TextureAssembler {
 public:
  static constexpr std::size_t kMaxAtlasBytes = 1 << 20;
  static constexpr std::size_t kMostOpen = 16;

  /// The report that this part completes. Errors: kFormat (a part that contradicts itself or those
  /// before it): it is left out.
  core::Expected<std::optional<TextureReport>> Add(const object_texture_t& message);
  /// Atlases given up for newer ones.
  std::uint64_t given_up() const { return given_up_; }

 private:
  struct Open {
    TextureReport report;  ///< faces once part 0 is here
    std::int32_t parts = 0;
    std::size_t atlas_bytes = 0;
    std::vector<std::vector<std::uint8_t>> bytes;  ///< by part; empty: not here
    std::size_t missing = 0;
  };
  std::list<Open> open_;  ///< last heard in front
  std::uint64_t given_up_ = 0;
};

}  // namespace kawara::comms
