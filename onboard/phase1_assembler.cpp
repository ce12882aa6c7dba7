#include "onboard/phase1_assembler.hpp"

#include <kawara/phase1_t.hpp>
#include <utility>

#include "comms/codec.hpp"
#include "comms/convert.hpp"
#include "vision/panorama_metadata.hpp"

namespace kawara::onboard {
namespace {

/// Pictures whose pose never comes (the core gave up) must not pile up.
constexpr std::size_t kMaxWaiting = 8;

vision::SourceFrame SourceOf(const drivers::Frame& frame) {
  vision::SourceFrame source;
  source.format = frame.format == drivers::PixelFormat::kJpeg ? vision::SourceFrame::Format::kJpeg
                                                              : vision::SourceFrame::Format::kRgb8;
  source.width_px = static_cast<int>(frame.width);
  source.height_px = static_cast<int>(frame.height);
  source.bytes = frame.bytes;
  return source;
}

/// A grey frame as the same picture in three equal colours; any other as it is.
std::shared_ptr<const drivers::Frame> InColour(std::shared_ptr<const drivers::Frame> frame) {
  if (frame->format != drivers::PixelFormat::kGrey8) return frame;
  auto colour = std::make_shared<drivers::Frame>(*frame);
  colour->format = drivers::PixelFormat::kRgb8;
  colour->bytes.clear();
  colour->bytes.reserve(3 * frame->bytes.size());
  for (const std::uint8_t level : frame->bytes) colour->bytes.insert(colour->bytes.end(), 3, level);
  return colour;
}

std::vector<std::uint8_t> Copy(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

core::Expected<Phase1Assembler> Phase1Assembler::Create(const vision::Phase1PictureConfig& config,
                                                        Identity identity, Emit emit,
                                                        Complain complain) {
  auto picture = vision::Phase1Picture::Create(config);
  if (!picture) return tl::unexpected(picture.error());
  const bool needs_attitude = config.panorama.level || config.panorama.north_up;
  return Phase1Assembler(std::move(*picture), needs_attitude, std::move(identity), std::move(emit),
                         std::move(complain));
}

Phase1Assembler::Phase1Assembler(vision::Phase1Picture picture, bool needs_attitude,
                                 Identity identity, Emit emit, Complain complain)
    : picture_(std::make_unique<vision::Phase1Picture>(std::move(picture))),
      needs_attitude_(needs_attitude),
      identity_(std::move(identity)),
      emit_(std::move(emit)),
      complain_(std::move(complain)) {}

void Phase1Assembler::OnFrame(std::int64_t epoch, std::shared_ptr<const drivers::Frame> frame) {
  if (waiting_.size() >= kMaxWaiting) {
    if (waiting_.begin()->second.pose) ++stats_.finished;
    waiting_.erase(waiting_.begin());
  }
  Picture picture;
  picture.frame = InColour(std::move(frame));
  waiting_.insert_or_assign(epoch, std::move(picture));
}

void Phase1Assembler::OnPose(const ExposurePose& pose) {
  const auto found = waiting_.find(pose.epoch);
  if (found == waiting_.end()) {
    ++stats_.poseless;
    ++stats_.finished;
    return;
  }
  found->second.pose = pose;
}

bool Phase1Assembler::Work() {
  for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
    const Outcome outcome = Advance(it->second);
    if (outcome == Outcome::kIdle) continue;
    if (outcome != Outcome::kWorked) {
      if (it->second.pose) ++stats_.finished;
      waiting_.erase(it);
    }
    return true;
  }
  return false;
}

Phase1Assembler::Outcome Phase1Assembler::Advance(Picture& picture) {
  if (!picture.preview_made) {
    if (needs_attitude_ && !picture.pose) return Outcome::kIdle;
    return MakePreview(picture);
  }
  if (picture.pose && !picture.preview_sent) {
    Send(*picture.pose, 0, picture.preview, {}, picture.preview_geometry);
    picture.preview_sent = true;
    return Outcome::kWorked;
  }
  if (!picture.full_made) return MakeFull(picture);
  if (!picture.pose) return Outcome::kIdle;
  Send(*picture.pose, 1, picture.full, picture.original, picture.full_geometry);
  return Outcome::kSent;
}

Phase1Assembler::Outcome Phase1Assembler::MakePreview(Picture& picture) {
  if (needs_attitude_ && picture.pose->camera.valid) {
    if (const auto set = picture_->SetAttitude(picture.pose->camera.attitude); !set)
      complain_(set.error());
  }
  const auto made = picture_->Preview(SourceOf(*picture.frame));
  if (!made) return Damaged(made.error());
  picture.preview = Copy(made->jpeg);
  picture.preview_geometry = made->geometry;
  picture.preview_made = true;
  return Outcome::kWorked;
}

Phase1Assembler::Outcome Phase1Assembler::MakeFull(Picture& picture) {
  const auto made = picture_->Full(SourceOf(*picture.frame));
  if (!made) return Damaged(made.error());
  picture.full = Copy(made->jpeg);
  picture.original = Copy(made->original);
  picture.full_geometry = made->geometry;
  picture.full_made = true;
  picture.frame.reset();
  return Outcome::kWorked;
}

Phase1Assembler::Outcome Phase1Assembler::Damaged(const core::Error& error) {
  ++stats_.damaged;
  complain_(error);
  return Outcome::kDamaged;
}

void Phase1Assembler::Send(const ExposurePose& pose, int stage, std::span<const std::uint8_t> jpeg,
                           std::span<const std::uint8_t> original,
                           const vision::PanoramaGeometry& geometry) {
  vision::PanoramaMetadata metadata;
  if (pose.camera.time.IsSet()) metadata.time = core::ToUtc(pose.camera.time);
  if (pose.camera.valid) {
    metadata.position = pose.camera.position;
    metadata.position_cov_enu_m2 = pose.camera.position_cov_enu_m2;
    metadata.attitude = picture_->PictureAttitude(pose.camera.attitude);
    metadata.attitude_sd_rad = pose.camera.attitude_sd_rad;
    metadata.gnss_age_s = pose.camera.gnss_age_s;
    metadata.geoid_separation_m = pose.geoid_separation_m;
    metadata.hdop = pose.hdop;
  }
  metadata.rtk = pose.camera.rtk;
  metadata.geometry = geometry;
  metadata.make = identity_.camera_make;
  metadata.model = identity_.camera_model;
  metadata.robot = identity_.robot;
  metadata.mission = identity_.mission;
  metadata.epoch = pose.epoch;
  const auto inserted =
      original.empty() ? vision::InsertPanoramaMetadata(jpeg, metadata, &with_metadata_)
                       : vision::InsertPanoramaMetadata(jpeg, original, metadata, &with_metadata_);
  if (!inserted) {
    ++stats_.damaged;
    return complain_(inserted.error());
  }

  phase1_t packet;
  packet.robot = identity_.robot;
  packet.mission = identity_.mission;
  packet.epoch = pose.epoch;
  packet.stage = static_cast<std::int8_t>(stage);
  packet.reason = static_cast<std::int8_t>(pose.reason);
  packet.pose = comms::ToMessage(pose.camera);
  packet.gps_minus_utc_s = pose.gps_minus_utc_s;
  packet.projection = "equirectangular";
  packet.width = geometry.width_px;
  packet.height = geometry.height_px;
  packet.n = static_cast<std::int32_t>(with_metadata_.size());
  packet.jpeg = with_metadata_;
  auto bytes = comms::Encode(packet);
  if (!bytes) return complain_(bytes.error());
  emit_(*bytes);
  ++(stage == 0 ? stats_.previews : stats_.pictures);
}

}  // namespace kawara::onboard
