// Messages as a hostile robot could send them: each is one byte that says which, two bytes of
// length (little-endian) and the body; the type's fingerprint is put before it. Whatever the intake
// hands on must be fit for the store and for file names, and nothing may get lost without a count.
#include <algorithm>
#include <cstdint>
#include <kawara/changed_object_t.hpp>
#include <kawara/counters_t.hpp>
#include <kawara/event_t.hpp>
#include <kawara/object_texture_t.hpp>
#include <kawara/phase1_t.hpp>
#include <kawara/road_stations_t.hpp>
#include <kawara/robot_pose_t.hpp>
#include <string>
#include <variant>
#include <vector>

#include "comms/codec.hpp"
#include "core/check.hpp"
#include "gis/kiwi/check_object.hpp"
#include "gis/record_check.hpp"
#include "station/intake.hpp"

namespace {

using namespace kawara;

using Bytes = std::span<const std::uint8_t>;

template <class T>
core::Expected<T> Decoded(Bytes body) {
  std::vector<std::uint8_t> message(8);
  const auto fingerprint = static_cast<std::uint64_t>(T::getHash());
  for (unsigned i = 0; i < 8; ++i)
    message[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
  message.insert(message.end(), body.begin(), body.end());
  return comms::Decode<T>(message);
}

void CheckPathName(const std::string& name) {
  const std::string safe = gis::SafePathName(name);
  CORE_CHECK(!safe.empty() && safe.front() != '.');
  CORE_CHECK(std::ranges::all_of(safe, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '-' || c == '_';
  }));
}

struct Checker {
  template <class Record>
  void operator()(const Record& record) const {
    CORE_CHECK(gis::CheckRecord(record).has_value());
  }
  void operator()(const comms::ObjectReport& report) const {
    CORE_CHECK(gis::CheckObject(report.object).has_value());
    CheckNames(report.robot, report.mission);
  }
  void operator()(const comms::TextureReport& report) const {
    CORE_CHECK(gis::CheckTextures(report.textures).has_value());
    CheckNames(report.robot, report.mission);
  }
  void operator()(const comms::RoadReport& report) const {
    for (const core::RoadStation& s : report.stations) CORE_CHECK(gis::CheckStation(s).has_value());
    CheckNames(report.robot, report.mission);
  }
  static void CheckNames(const std::string& robot, const std::string& mission) {
    CORE_CHECK(gis::IsCleanText(robot, gis::kMaxNameBytes));
    CORE_CHECK(gis::IsCleanText(mission, gis::kMaxNameBytes));
  }
};

void CheckItem(const station::Item& item) {
  std::visit(Checker{}, item.record);
  if (const gis::PanoramaRecord* picture = item.picture()) {
    CheckPathName(picture->robot);
    CheckPathName(picture->mission);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  station::StationConfig config;
  config.pose_rate_hz = size % 2 == 0 ? 1.0 : 1000.0;
  std::int64_t handed = 0, roads = 0;
  station::Intake intake(config, [&](const station::Item& item) {
    CheckItem(item);
    ++(std::holds_alternative<comms::RoadReport>(item.record) ? roads : handed);
  });
  const core::MonoTime received = core::MonoTime::FromNs(1);
  for (Bytes rest(data, size); rest.size() >= 3;) {
    const unsigned kind = rest[0];
    const std::size_t length = std::min<std::size_t>(rest[1] + 256U * rest[2], rest.size() - 3);
    const Bytes body = rest.subspan(3, length);
    rest = rest.subspan(3 + length);
    switch (kind % 8) {
      case 0:
        if (const auto m = Decoded<phase1_t>(body)) intake.OnPhase1(*m, received);
        break;
      case 1:
      case 2:
        if (const auto m = Decoded<robot_pose_t>(body)) intake.OnPose(*m, kind % 8 == 2, received);
        break;
      case 3:
        if (const auto m = Decoded<event_t>(body)) intake.OnEvent(*m, received);
        break;
      case 4:
        if (const auto m = Decoded<changed_object_t>(body)) intake.OnObject(*m, received);
        break;
      case 5:
        if (const auto m = Decoded<object_texture_t>(body)) intake.OnTexture(*m, received);
        break;
      case 6:
        if (const auto m = Decoded<road_stations_t>(body)) intake.OnRoad(*m, received);
        break;
      default:
        if (const auto m = Decoded<counters_t>(body)) intake.OnCounters(*m);
        break;
    }
  }
  const station::IntakeStats& stats = intake.stats();
  CORE_CHECK(stats.pictures + stats.previews + stats.poses_kept + stats.events + stats.objects +
                 stats.textures ==
             handed);
  CORE_CHECK(roads > 0 || stats.stations == 0);
  CORE_CHECK(intake.missing_pictures() >= 0 && intake.missing_previews() >= 0);
  (void)intake.RobotLosses();
  return 0;
}
