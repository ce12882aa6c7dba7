#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// The whole robot, live: bus, log, camera, corrections, pictures, and the real-time loop in their
/// midst. Started in that order, stopped in reverse, so that nothing that was measured is lost on
/// the way out.
class LiveRobot {
 public:
  /// Errors: no bus, no log folder, a picture configuration that contradicts itself. Instruments
  /// that are missing are no error: they are waited for and told about.
  static core::Expected<std::unique_ptr<LiveRobot>> Start(const OnboardConfig& config);
  ~LiveRobot();  ///< Stop()
  LiveRobot(const LiveRobot&) = delete;
  LiveRobot& operator=(const LiveRobot&) = delete;

  void Stop();
  /// The real-time loop and the pump have both gone round since the last call (or since Start).
  bool IsAlive();
  /// One line for the operator: fixes, pictures, drops, where the log is. After Stop().
  std::string Summary() const;

 private:
  struct Parts;
  explicit LiveRobot(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// "20260708T063000Z": the default name of a mission that begins then.
std::string MissionAt(core::UtcTime begin);
/// The configuration as a log shows it: complete, with the password blanked.
std::string PublicYaml(OnboardConfig config);
/// Event 0 of every log: CONFIG, encoded.
std::vector<std::uint8_t> ConfigMessage(const OnboardConfig& config);

}  // namespace kawara::onboard
