#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/camera.hpp"
#include "onboard/config.hpp"
#include "onboard/core_sink.hpp"
#include "vision/phase1_picture.hpp"

namespace kawara::onboard {

/// Makes phase-1 packets (phase1_t) out of frames and their poses. The work is cut into pieces, of
/// which Work() does the most urgent: preview made, preview sent, full picture made, full picture
/// sent; so a pose that comes while the full picture is still to be made sends the preview on its
/// way first. A picture is made without waiting for its pose (except levelled and north-up
/// panoramas, which need it); the pose is written into it (EXIF, GPano) and beside it when it
/// comes. The same frame and pose give the same bytes. One thread only.
class Phase1Assembler {
 public:
  struct Identity {
    std::string robot;
    std::string mission;
    std::string camera_make;
    std::string camera_model;
  };
  struct Stats {
    std::int64_t previews = 0;
    std::int64_t pictures = 0;
    std::int64_t damaged = 0;   ///< frames that were no picture
    std::int64_t poseless = 0;  ///< poses for pictures that are not here
    std::int64_t finished = 0;  ///< poses dealt with, whatever came of it: one an order
  };
  /// Gets each packet as LCM bytes for channel PHASE1.
  using Emit = std::function<void(std::span<const std::uint8_t>)>;
  using Complain = std::function<void(const core::Error&)>;

  /// Errors: the picture's configuration, naming the key.
  static core::Expected<Phase1Assembler> Create(const vision::Phase1PictureConfig& config,
                                                Identity identity, Emit emit, Complain complain);

  /// A selected frame. Only noted down.
  void OnFrame(std::int64_t epoch, std::shared_ptr<const drivers::Frame> frame);
  /// Its pose. Only noted down.
  void OnPose(const ExposurePose& pose);
  /// Does the next piece of work, tens of milliseconds at most; false: there is none.
  bool Work();
  const Stats& stats() const { return stats_; }

 private:
  struct Picture {
    std::shared_ptr<const drivers::Frame> frame;
    std::optional<ExposurePose> pose;
    bool preview_made = false;
    bool preview_sent = false;
    bool full_made = false;
    std::vector<std::uint8_t> preview;
    std::vector<std::uint8_t> full;
    std::vector<std::uint8_t> original;
    vision::PanoramaGeometry preview_geometry;
    vision::PanoramaGeometry full_geometry;
  };
  enum class Outcome : std::uint8_t { kIdle, kWorked, kSent, kDamaged };
  Phase1Assembler(vision::Phase1Picture picture, bool needs_attitude, Identity identity, Emit emit,
                  Complain complain);
  Outcome Advance(Picture& picture);
  Outcome MakePreview(Picture& picture);
  Outcome MakeFull(Picture& picture);
  Outcome Damaged(const core::Error& error);
  void Send(const ExposurePose& pose, int stage, std::span<const std::uint8_t> jpeg,
            std::span<const std::uint8_t> original, const vision::PanoramaGeometry& geometry);

  std::unique_ptr<vision::Phase1Picture> picture_;
  bool needs_attitude_;
  Identity identity_;
  Emit emit_;
  Complain complain_;
  std::map<std::int64_t, Picture> waiting_;  ///< by epoch; bounded by the orders the core allows
  std::vector<std::uint8_t> with_metadata_;
  Stats stats_;
};

}  // namespace kawara::onboard
