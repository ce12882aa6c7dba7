#include "onboard/mapper/watch/change_reporter.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iterator>
#include <span>
#include <system_error>
#include <utility>

#include "vision/sides/side_texture.hpp"

namespace kawara::mapper {
namespace {

/// A thing whose middle is known so well is worth a picture.
constexpr double kPlaced = 0.5;  // m
/// Of what is said again on the bus.
constexpr core::Duration kRepeat = core::Seconds(1);

double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Letters, digits, '-', '_' and '.' only, as uids are made of.
std::string PlainName(std::string name) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_' && c != '.')
      c = '_';
  return name;
}

std::string Text(const vision::Alignment& a) {
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(),
                "the map lies %+.3f m east, %+.3f m north, %+.3f m up and %+.2f deg off the "
                "reference: taken into account",
                -a.shift_m.x(), -a.shift_m.y(), -a.shift_m.z(), -a.turn_rad * core::kDegFromRad);
  return line.data();
}

std::string Text(const core::ChangedObject& object) {
  std::array<char, 256> line{};
  const auto& box = object.box;
  std::snprintf(line.data(), line.size(),
                "%s: %s %s, %.1f x %.1f x %.1f m at %.1f m east, %.1f m north", object.uid.c_str(),
                ToString(object.state), ToString(object.size_class), box.size_m.x(), box.size_m.y(),
                box.size_m.z(), box.centre_m.x(), box.centre_m.y());
  return line.data();
}

double CentreSd(const core::ChangedObject& object) {
  return std::sqrt(std::max(0.0, object.covariance(0, 0) + object.covariance(1, 1)));
}

core::Expected<void> TakeUpKnown(const ReporterOptions& options, vision::ChangeWatch& watch) {
  std::error_code error;
  const auto take = [&](const std::filesystem::path& log, bool own) -> core::Expected<void> {
    auto reports = ReadObjects(log);
    if (!reports) return tl::unexpected(reports.error());
    std::vector<core::ChangedObject> objects;
    for (comms::ObjectReport& report : *reports) {
      if (auto same = vision::KnownPlace::CheckOrigin(watch.place().reference, report.origin);
          !same)
        return core::Fail(core::ErrorCode::kInvalidArgument,
                          log.string() + ": its objects are of another map than the reference");
      objects.push_back(std::move(report.object));
    }
    watch.TakeUp(std::move(objects), own);
    return {};
  };
  for (const auto& log : options.known)
    if (auto done = take(log, false); !done) return done;
  if (!options.fresh && std::filesystem::exists(options.journal, error))
    return take(options.journal, true);
  return {};
}

}  // namespace

ChangeReporter::ChangeReporter(ReporterOptions options, vision::ChangeWatch watch,
                               ChangeJournal journal)
    : options_(std::move(options)),
      watch_(std::move(watch)),
      journal_(std::move(journal)),
      to_journal_({options_.robot, options_.mission, *options_.origin, core::Duration{}},
                  [this](std::string_view channel, const std::vector<std::uint8_t>& message) {
                    return journal_.Append(channel, message, time_);
                  }) {
  if (options_.send)
    to_bus_.emplace(
        comms::PublisherOptions{options_.robot, options_.mission, *options_.origin, kRepeat},
        options_.send);
}

core::Expected<std::unique_ptr<ChangeReporter>> ChangeReporter::Open(ReporterOptions options) {
  if (!options.origin)
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "nobody says where the model's map lies, so nothing can be compared with a "
                      "reference: give its origin in camera.yaml");
  auto same = vision::KnownPlace::CheckOrigin(options.reference, *options.origin);
  if (!same) return tl::unexpected(same.error());
  options.reference.origin = options.origin;
  auto place = vision::KnownPlace::Of(std::move(options.reference));
  if (!place) return tl::unexpected(place.error());
  vision::WatchOptions watching;
  watching.tracker.uid_prefix = PlainName(options.robot + "-" + options.mission);
  watching.tracker.robot = options.robot;
  vision::ChangeWatch watch(std::move(*place), watching);
  if (auto done = TakeUpKnown(options, watch); !done) return tl::unexpected(done.error());
  auto journal = ChangeJournal::Open(options.journal, options.fresh);
  if (!journal) return tl::unexpected(journal.error());
  return std::unique_ptr<ChangeReporter>(
      new ChangeReporter(std::move(options), std::move(watch), std::move(*journal)));
}

core::Expected<void> ChangeReporter::OnGrown(const Grown& grown) {
  if (!grown.last && !watch_.IsDue(grown.here)) return {};
  const double start_s = ThreadCpuSeconds();
  const core::UtcTime now = core::ToUtc(grown.time);
  vision::ChangeNews news;
  if (watch_.IsDue(grown.here)) news = watch_.Look(grown.map, grown.here, grown.known_m, now);
  if (grown.last) {
    auto rest = watch_.Settle();
    std::move(rest.begin(), rest.end(), std::back_inserter(news.settled));
  }
  Say(news);
  auto told = Tell(news, grown);
  cpu_s_ += ThreadCpuSeconds() - start_s;
  return told;
}

void ChangeReporter::Say(const vision::ChangeNews& news) {
  if (news.trouble != trouble_) {
    trouble_ = news.trouble;
    options_.say(trouble_.empty() ? "the map fits the reference again"
                                  : "warning: no changes are looked for: " + trouble_);
  }
  const bool shifted = news.alignment && news.alignment->shift_m.norm() > 0.0;
  if (shifted && !shifted_) options_.say(Text(*news.alignment));
  if (news.alignment) {
    shifted_ = shifted;
    const std::string unchecked = vision::Unchecked(*news.alignment);
    if (!unchecked.empty() && !unchecked_) options_.say(unchecked);
    unchecked_ = !unchecked.empty();
  }
  for (const core::ChangedObject& object : news.revisions)
    if (object.revision == 1 || object.state != core::ChangeState::kNew) options_.say(Text(object));
}

core::Expected<void> ChangeReporter::Tell(const vision::ChangeNews& news, const Grown& grown) {
  time_ = core::ToUtc(grown.time);
  for (const core::ChangedObject& object : news.revisions) {
    if (auto done = ToAll([&](auto& publisher) { return publisher.Publish(object); }); !done)
      return done;
    ++told_;
    // A picture as soon as it is known how large the thing is, and the best one at the end.
    const bool gone = object.state == core::ChangeState::kGone;
    if (gone || pictured_.contains(object.uid) || CentreSd(object) > kPlaced) continue;
    if (auto done = TellTextures(object, grown); !done) return done;
  }
  for (const core::ChangedObject& object : news.settled) {
    core::ChangedObject last = object;
    // One picture a revision: who has the first does not take a second for it.
    const auto pictured = pictured_.find(object.uid);
    if (pictured != pictured_.end() && pictured->second == object.revision) {
      last = watch_.Reissue(object.uid).value_or(object);
      if (auto done = ToAll([&](auto& publisher) { return publisher.Publish(last); }); !done)
        return done;
      ++told_;
    }
    if (auto done = TellTextures(last, grown); !done) return done;
  }
  if (!news.stations.empty()) {
    stations_ += news.stations.size();
    const std::span<const core::RoadStation> stations(news.stations);
    if (auto done = ToAll([&](auto& publisher) { return publisher.Publish(stations); }); !done)
      return done;
  }
  return journal_.Commit();
}

core::Expected<void> ChangeReporter::TellTextures(const core::ChangedObject& object,
                                                  const Grown& grown) {
  std::vector<vision::SideView> views;
  for (NamedView& named : grown.views()) {
    vision::SideView view{.view = named.view};
    view.source = options_.mission + "/" + named.name;
    view.taken = core::ToUtc(named.time);
    views.push_back(std::move(view));
  }
  const auto textures = vision::MakeSideTextures(object, views, {}, encoder_);
  if (!textures) return tl::unexpected(textures.error());
  if (textures->atlas_jpeg.empty()) return {};
  pictured_[object.uid] = object.revision;
  ++textures_;
  return ToAll(
      [&](auto& publisher) { return publisher.Publish(object.uid, object.revision, *textures); });
}

core::Expected<void> ChangeReporter::ToAll(
    const std::function<core::Expected<void>(comms::ObjectPublisher&)>& publish) {
  auto kept = publish(to_journal_);
  if (to_bus_) HearBus(publish(*to_bus_));
  return kept;
}

void ChangeReporter::HearBus(const core::Expected<void>& sent) {
  const std::string trouble = sent ? std::string() : sent.error().message;
  if (trouble == bus_trouble_) return;
  bus_trouble_ = trouble;
  options_.say(sent ? "changes go out on the bus again"
                    : "warning: changes do not go out on the bus, they are kept in " +
                          options_.journal.string() + ": " + trouble);
}

void ChangeReporter::Repeat(core::MonoTime now) {
  if (to_bus_) HearBus(to_bus_->Repeat(now));
}

}  // namespace kawara::mapper
