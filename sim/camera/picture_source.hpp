#pragma once
#include <cstdint>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::sim {

/// What is written into every simulated picture, so that a picture and its pose can be proved to
/// belong together.
struct Caption {
  std::uint32_t trigger_sequence = 0;
  core::GpsTime exposure;  ///< read back as milliseconds of the GPS week
  std::uint32_t exposure_ms_of_week() const;
};

/// A compressed picture as a camera delivers it.
struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> jpeg;
  /// Start of the exposure it really shows, if that is not the one asked for. Not set: as asked.
  core::GpsTime exposed = {};
};

/// Where the simulated camera's pictures come from. One thread.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  /// Work that can be done before the trigger, which is expected at this time. Takes its time.
  virtual void Prepare(core::GpsTime expected) = 0;
  /// The picture of the exposure at caption.exposure. Should be quick after a good Prepare().
  virtual core::Expected<Picture> Expose(const Caption& caption) = 0;
  /// Exposures so far whose picture had to be made after the trigger.
  virtual std::uint64_t made_late() const { return 0; }
};

}  // namespace kawara::sim
