#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/camera.hpp"
#include "onboard/config.hpp"
#include "onboard/core_sink.hpp"
#include "vision/phase1_picture.hpp"

namespace kawara::onboard {

/// Makes phase-1 packets (phase1_t) out of frames and their poses: the picture is encoded as soon
/// as the frame is here (with levelled or north-up panoramas only when its pose is, too), the pose
/// is written into it (EXIF, GPano) and beside it when it comes; then the preview goes out, and the
/// full picture after it. The same frame and pose give the same bytes. One thread only.
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
  };
  /// Gets each packet as LCM bytes for channel PHASE1.
  using Emit = std::function<void(std::span<const std::uint8_t>)>;
  using Complain = std::function<void(const core::Error&)>;

  /// Errors: the picture's configuration, naming the key.
  static core::Expected<Phase1Assembler> Create(const vision::Phase1PictureConfig& config,
                                                Identity identity, Emit emit, Complain complain);

  /// A selected frame.
  void OnFrame(std::int64_t epoch, std::shared_ptr<const drivers::Frame> frame);
  /// Its pose. Sends both packets and forgets the epoch.
  void OnPose(const ExposurePose& pose);
  const Stats& stats() const { return stats_; }

 private:
  struct Picture {
    std::shared_ptr<const drivers::Frame> frame;
    bool encoded = false;
    std::vector<std::uint8_t> preview;
    std::vector<std::uint8_t> full;
    std::vector<std::uint8_t> original;
    vision::PanoramaGeometry preview_geometry;
    vision::PanoramaGeometry full_geometry;
  };
  Phase1Assembler(vision::Phase1Picture picture, bool needs_attitude, Identity identity, Emit emit,
                  Complain complain);
  bool EncodePicture(Picture& picture);
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
