#include "comms/texture_message.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace kawara::comms {
namespace {

constexpr std::int32_t kMostSidePx = 1 << 14;

tl::unexpected<core::Error> Bad(const std::string& what) {
  return core::Fail(core::ErrorCode::kFormat, "object_texture_t: " + what);
}

void AddFaces(const core::ObjectTextures& textures, object_texture_t& m) {
  for (const core::FaceTexture& face : textures.faces) {
    m.side.push_back(static_cast<std::int8_t>(face.side));
    auto& corners = m.corners_px.emplace_back();
    for (const auto& corner : face.corners_px)
      for (const double v : corner) corners.push_back(static_cast<float>(v));
    m.seen_share.push_back(static_cast<float>(face.seen_share));
    m.taken_ns.push_back(face.taken.ns());
    m.source.push_back(face.source);
    ++m.n_faces;
  }
}

core::Expected<std::vector<core::FaceTexture>> FacesOf(const object_texture_t& m) {
  std::vector<core::FaceTexture> faces;
  if (m.n_faces > static_cast<std::int32_t>(core::kBoxSides)) return Bad("too many faces");
  for (std::size_t i = 0; i < static_cast<std::size_t>(m.n_faces); ++i) {
    if (m.side[i] < 0 || static_cast<std::size_t>(m.side[i]) >= core::kBoxSides)
      return Bad("unknown side");
    if (!(m.seen_share[i] >= 0.0F && m.seen_share[i] <= 1.0F)) return Bad("share out of range");
    core::FaceTexture face;
    face.side = static_cast<core::BoxSide>(m.side[i]);
    for (std::size_t k = 0; k < 8; ++k) {
      const double v = static_cast<double>(m.corners_px[i][k]);
      if (!(v >= 0.0 && v <= (k % 2 == 0 ? m.width_px : m.height_px)))
        return Bad("a corner outside of the atlas");
      face.corners_px[k / 2][k % 2] = v;
    }
    face.seen_share = static_cast<double>(m.seen_share[i]);
    face.taken = core::UtcTime::FromNs(m.taken_ns[i]);
    face.source = m.source[i];
    faces.push_back(std::move(face));
  }
  return faces;
}

/// What is wrong with a part by itself; null: nothing.
const char* Fault(const object_texture_t& m) {
  if (m.uid.empty()) return "no uid";
  if (m.revision < 1) return "revision below 1";
  if (m.width_px < 1 || m.height_px < 1 || m.width_px > kMostSidePx || m.height_px > kMostSidePx)
    return "size out of range";
  if (m.atlas_bytes < 1 ||
      static_cast<std::size_t>(m.atlas_bytes) > TextureAssembler::kMaxAtlasBytes)
    return "atlas too large";
  const auto parts = (static_cast<std::size_t>(m.atlas_bytes) - 1) / kTexturePartBytes + 1;
  if (m.parts < 0 || static_cast<std::size_t>(m.parts) != parts || m.part < 0 || m.part >= m.parts)
    return "not a part of that atlas";
  const std::size_t before = static_cast<std::size_t>(m.part) * kTexturePartBytes;
  const std::size_t size =
      std::min(kTexturePartBytes, static_cast<std::size_t>(m.atlas_bytes) - before);
  return m.jpeg.size() == size ? nullptr : "a part of the wrong length";
}

}  // namespace

core::Expected<std::vector<object_texture_t>> ToMessages(const TextureReport& report) {
  const auto& jpeg = report.textures.atlas_jpeg;
  if (jpeg.empty() || jpeg.size() > TextureAssembler::kMaxAtlasBytes)
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      report.uid + ": an atlas of " + std::to_string(jpeg.size()) + " bytes");
  std::vector<object_texture_t> messages;
  for (std::size_t at = 0; at < jpeg.size(); at += kTexturePartBytes) {
    object_texture_t m{};
    m.robot = report.robot;
    m.mission = report.mission;
    m.uid = report.uid;
    m.revision = static_cast<std::int64_t>(report.revision);
    m.part = static_cast<std::int32_t>(messages.size());
    m.parts = static_cast<std::int32_t>((jpeg.size() - 1) / kTexturePartBytes + 1);
    m.atlas_bytes = static_cast<std::int32_t>(jpeg.size());
    m.width_px = static_cast<std::int32_t>(report.textures.width_px);
    m.height_px = static_cast<std::int32_t>(report.textures.height_px);
    if (messages.empty()) AddFaces(report.textures, m);
    const std::size_t end = std::min(jpeg.size(), at + kTexturePartBytes);
    m.jpeg.assign(jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                  jpeg.begin() + static_cast<std::ptrdiff_t>(end));
    m.n = static_cast<std::int32_t>(m.jpeg.size());
    messages.push_back(std::move(m));
  }
  return messages;
}

core::Expected<std::optional<TextureReport>> TextureAssembler::Add(const object_texture_t& m) {
  if (const char* fault = Fault(m)) return Bad(fault);
  std::vector<core::FaceTexture> faces;
  if (m.part == 0) {
    auto read = FacesOf(m);
    if (!read) return tl::unexpected(read.error());
    faces = std::move(*read);
  }
  const auto revision = static_cast<std::uint64_t>(m.revision);
  const auto size = static_cast<std::size_t>(m.atlas_bytes);
  auto open = std::find_if(open_.begin(), open_.end(), [&](const Open& o) {
    return o.report.uid == m.uid && o.report.revision == revision && o.report.robot == m.robot;
  });
  // One that was made anew after a restart may be of another size.
  if (open != open_.end() && open->atlas_bytes != size) open = (open_.erase(open), open_.end());
  if (open == open_.end()) {
    if (open_.size() == kMostOpen) {
      open_.pop_back();
      ++given_up_;
    }
    Open fresh;
    fresh.report = {m.robot, m.mission, m.uid, revision, {}};
    fresh.report.textures.width_px = static_cast<std::uint32_t>(m.width_px);
    fresh.report.textures.height_px = static_cast<std::uint32_t>(m.height_px);
    fresh.parts = m.parts;
    fresh.atlas_bytes = size;
    fresh.bytes.resize(static_cast<std::size_t>(m.parts));
    fresh.missing = fresh.bytes.size();
    open_.push_front(std::move(fresh));
  } else {
    open_.splice(open_.begin(), open_, open);
  }
  Open& atlas = open_.front();
  auto& bytes = atlas.bytes[static_cast<std::size_t>(m.part)];
  if (m.part == 0) atlas.report.textures.faces = std::move(faces);
  if (bytes.empty()) --atlas.missing;
  bytes = m.jpeg;
  if (atlas.missing > 0) return std::optional<TextureReport>();
  TextureReport report = std::move(atlas.report);
  for (const auto& part : atlas.bytes)
    report.textures.atlas_jpeg.insert(report.textures.atlas_jpeg.end(), part.begin(), part.end());
  open_.pop_front();
  return std::optional(std::move(report));
}

}  // namespace kawara::comms
