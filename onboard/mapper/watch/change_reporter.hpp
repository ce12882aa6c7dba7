#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "comms/object_publisher.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "onboard/mapper/model_builder.hpp"
#include "onboard/mapper/watch/change_journal.hpp"
#include "vision/change/change_watch.hpp"
#include "vision/jpeg.hpp"

namespace kawara::mapper {

struct ReporterOptions {
  vision::ReferenceMap reference;
  std::vector<std::filesystem::path> known;  ///< logs of earlier missions: their objects are known
  std::filesystem::path journal;
  bool fresh = false;  ///< forget what the journal holds
  std::string robot, mission;
  std::optional<core::Geodetic> origin;  ///< of the model's map
  /// Beside the journal; empty: nowhere. What it answers is not waited for.
  comms::ObjectPublisher::Send send;
  std::function<void(const std::string&)> say;  ///< lines that people should read
};

/// The 3rd update of a model that grows: what the watch finds goes into the journal and, live, on
/// the bus. Objects keep their uids over restarts. One thread.
class ChangeReporter {
 public:
  /// Errors: those of the logs; kInvalidArgument: no road, no or another origin.
  static core::Expected<std::unique_ptr<ChangeReporter>> Open(ReporterOptions options);
  ChangeReporter(const ChangeReporter&) = delete;
  ChangeReporter& operator=(const ChangeReporter&) = delete;

  /// For ModelBuilder. Errors: those of the journal.
  core::Expected<void> OnGrown(const Grown& grown);
  /// What is said again on the bus for those who missed it, if it is time.
  void Repeat(core::MonoTime now);

  std::size_t objects() const { return watch_.objects().size(); }
  std::uint64_t told() const { return told_; }
  std::uint64_t textures() const { return textures_; }
  std::uint64_t stations() const { return stations_; }
  /// CPU time of this thread that was spent on it [s].
  double cpu_s() const { return cpu_s_; }

 private:
  ChangeReporter(ReporterOptions options, vision::ChangeWatch watch, ChangeJournal journal);
  core::Expected<void> Tell(const vision::ChangeNews& news, const Grown& grown);
  /// Pictures of its sides: a first one early, the last one when it has been left behind.
  core::Expected<void> TellTextures(const core::ChangedObject& object, const Grown& grown);
  void Say(const vision::ChangeNews& news);
  /// Error: the journal's; the bus is not waited for.
  core::Expected<void> ToAll(
      const std::function<core::Expected<void>(comms::ObjectPublisher&)>& publish);
  void HearBus(const core::Expected<void>& sent);

  ReporterOptions options_;
  vision::ChangeWatch watch_;
  ChangeJournal journal_;
  core::UtcTime time_;  ///< of what is being told
  comms::ObjectPublisher to_journal_;
  std::optional<comms::ObjectPublisher> to_bus_;
  std::string bus_trouble_;
  vision::JpegEncoder encoder_;
  std::map<std::string, std::uint64_t> pictured_;  ///< revision of each uid's newest picture
  std::string trouble_;
  bool shifted_ = false, unchecked_ = false;
  std::uint64_t told_ = 0, textures_ = 0, stations_ = 0;
  double cpu_s_ = 0.0;
};

}  // namespace kawara::mapper
