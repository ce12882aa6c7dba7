#include "gis/cloud/cloud.hpp"

#include <algorithm>
#include <cstring>

#include "gis/cloud/cloud_reader.hpp"
#include "gis/frame/crs_to_enu.hpp"

namespace kawara::gis {
namespace {

core::Expected<CloudReaderPtr> Open(const std::string& path, const CloudReadOptions& options) {
  auto source = ByteSource::Open(path, options.buffer_bytes);
  if (!source) return tl::unexpected(source.error());
  return OpenCloud(std::move(*source));
}

template <class Each>
core::Expected<void> ForEachChunk(CloudReader& reader, const CloudReadOptions& options,
                                  const Each& each) {
  const std::size_t most = std::max<std::size_t>(options.chunk_points, 1);
  while (true) {
    const auto chunk = reader.Next(most);
    if (!chunk) return tl::unexpected(chunk.error());
    if (chunk->empty()) return {};
    each(*chunk);
  }
}

/// From one place's tangent plane to another's: both are the same space, turned and moved.
struct RigidMove {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d move = Eigen::Vector3d::Zero();
};
RigidMove MoveBetween(const core::Geodetic& from, const core::Geodetic& to) {
  const core::LocalEnu source(from), target(to);
  const auto take = [&](const Eigen::Vector3d& p) {
    return target.FromGeodetic(source.ToGeodetic(p));
  };
  constexpr double kArm_m = 1000.0;
  RigidMove m;
  m.move = take(Eigen::Vector3d::Zero());
  for (Eigen::Index k = 0; k < 3; ++k)
    m.turn.col(k) = (take(Eigen::Vector3d::Unit(k) * kArm_m) - m.move) / kArm_m;
  return m;
}

/// Turns a chunk's positions into the map's; `positions` is for whoever needs them in a row.
using Placing = std::function<void(std::vector<CloudPoint>&)>;

core::Expected<Placing> PlacingOf(const CloudInfo& info, const std::string& path,
                                  const MapFrame& frame, HeightDatum& heights) {
  if (frame.coordinates == Coordinates::kLocalMetres) return Placing([](auto&) {});
  if (info.origin) {
    heights = HeightDatum::kEllipsoidal;
    return Placing([m = MoveBetween(*info.origin, frame.origin)](std::vector<CloudPoint>& points) {
      for (CloudPoint& p : points) p.position = m.turn * p.position + m.move;
    });
  }
  if (info.crs.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path + ": it does not say where it lies (no reference system, no origin): " +
                          "say that its coordinates are local metres, and of which origin");
  auto made = CrsToEnu::Make(info.crs, frame);
  if (!made) return core::Fail(made.error().code, path + ": " + made.error().message);
  heights = made->heights();
  const auto crs = std::make_shared<CrsToEnu>(std::move(*made));
  return Placing(
      [crs, positions = std::vector<Eigen::Vector3d>()](std::vector<CloudPoint>& points) mutable {
        positions.clear();
        for (const CloudPoint& p : points) positions.push_back(p.position);
        crs->Convert(positions);
        for (std::size_t i = 0; i < points.size(); ++i) points[i].position = positions[i];
      });
}

}  // namespace

core::Expected<CloudReaderPtr> OpenCloud(ByteSource source) {
  const auto first = source.Peek(4);
  const auto begins = [&first](const char* with, std::size_t size) {
    return first.size() >= size && std::memcmp(first.data(), with, size) == 0;
  };
  if (begins("LASF", 4)) return OpenLas(std::move(source));
  if (begins("ply", 3)) return OpenPly(std::move(source));
  return core::Fail(
      core::ErrorCode::kFormat,
      source.name() + (first.empty() ? ": is empty" : ": is neither a PLY nor a LAS file"));
}

core::Expected<CloudInfo> ReadCloudInfo(const std::string& path) {
  auto reader = Open(path, {});
  if (!reader) return tl::unexpected(reader.error());
  return (*reader)->info();
}

core::Expected<CloudInfo> ReadCloud(const std::string& path, const CloudVisitor& visitor,
                                    const CloudReadOptions& options) {
  auto reader = Open(path, options);
  if (!reader) return tl::unexpected(reader.error());
  if (auto done = ForEachChunk(**reader, options, visitor); !done)
    return tl::unexpected(done.error());
  return (*reader)->info();
}

core::Expected<CloudInfo> ReadCloudEnu(const std::string& path, const MapFrame& frame,
                                       const CloudVisitor& visitor,
                                       const CloudReadOptions& options) {
  auto reader = Open(path, options);
  if (!reader) return tl::unexpected(reader.error());
  HeightDatum heights = HeightDatum::kUnknown;
  const auto place = PlacingOf((*reader)->info(), path, frame, heights);
  if (!place) return tl::unexpected(place.error());
  std::vector<CloudPoint> points;
  std::uint64_t misplaced = 0;
  const auto done = ForEachChunk(**reader, options, [&](std::span<const CloudPoint> chunk) {
    points.assign(chunk.begin(), chunk.end());
    (*place)(points);
    misplaced += static_cast<std::uint64_t>(
        std::erase_if(points, [](const CloudPoint& p) { return !p.position.allFinite(); }));
    if (!points.empty()) visitor(points);
  });
  if (!done) return tl::unexpected(done.error());
  CloudInfo info = (*reader)->info();
  info.heights = heights;
  info.delivered -= misplaced;
  info.not_finite += misplaced;
  return info;
}

core::Expected<core::Geodetic> OriginOf(const CloudInfo& info, double geoid_separation_m) {
  if (info.origin) return *info.origin;
  if (info.crs.empty() || !info.bounds)
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "the cloud does not say where it lies: name the map's origin");
  // Any origin leads there: its plane is only the way.
  const MapFrame frame{{}, Coordinates::kFromFile, geoid_separation_m};
  auto crs = CrsToEnu::Make(info.crs, frame);
  if (!crs) return tl::unexpected(crs.error());
  Eigen::Vector3d middle = ((*info.bounds)[0] + (*info.bounds)[1]) / 2.0;
  middle.z() = (*info.bounds)[0].z();
  const Eigen::Vector3d enu_m = crs->Exact(middle);
  if (!enu_m.allFinite())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "the cloud's bounds lie outside its reference system: name the map's origin");
  return core::LocalEnu(frame.origin).ToGeodetic(enu_m);
}

}  // namespace kawara::gis
