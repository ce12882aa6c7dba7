#include "sim/faults/faults.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

namespace kawara::sim {
namespace {

constexpr double kDefaultLength_s = 5.0;
constexpr double kLatest_s = 1e6;

constexpr auto kNames = std::to_array<std::pair<FaultKind, const char*>>({
    {FaultKind::kGpsUnplug, "gps.unplug"},
    {FaultKind::kGpsSilent, "gps.silent"},
    {FaultKind::kGpsGarbage, "gps.garbage"},
    {FaultKind::kGpsStuck, "gps.stuck"},
    {FaultKind::kGpsBadSum, "gps.badsum"},
    {FaultKind::kGpsNoFix, "gps.nofix"},
    {FaultKind::kGpsPower, "gps.power"},
    {FaultKind::kGpsClockStep, "gps.clockstep"},
    {FaultKind::kGpsNoPps, "gps.nopps"},
    {FaultKind::kPpsLost, "pps.lost"},
    {FaultKind::kPpsJitter, "pps.jitter"},
    {FaultKind::kPpsDouble, "pps.double"},
    {FaultKind::kAhrsUnplug, "ahrs.unplug"},
    {FaultKind::kAhrsSilent, "ahrs.silent"},
    {FaultKind::kAhrsGarbage, "ahrs.garbage"},
    {FaultKind::kAhrsStuck, "ahrs.stuck"},
    {FaultKind::kAhrsClockStep, "ahrs.clockstep"},
    {FaultKind::kCameraHang, "camera.hang"},
    {FaultKind::kCameraMiss, "camera.miss"},
    {FaultKind::kCameraDouble, "camera.double"},
    {FaultKind::kCameraLate, "camera.late"},
    {FaultKind::kCameraDark, "camera.dark"},
    {FaultKind::kCameraDisconnect, "camera.disconnect"},
    {FaultKind::kLaser1Unplug, "laser1.unplug"},
    {FaultKind::kLaser1Silent, "laser1.silent"},
    {FaultKind::kLaser1Garbage, "laser1.garbage"},
    {FaultKind::kLaser1Stuck, "laser1.stuck"},
    {FaultKind::kLaser1Power, "laser1.power"},
    {FaultKind::kLaser2Unplug, "laser2.unplug"},
    {FaultKind::kLaser2Silent, "laser2.silent"},
    {FaultKind::kLaser2Garbage, "laser2.garbage"},
    {FaultKind::kLaser2Stuck, "laser2.stuck"},
    {FaultKind::kLaser2Power, "laser2.power"},
    {FaultKind::kRadioDown, "radio.down"},
    {FaultKind::kRadioLoss, "radio.loss"},
    {FaultKind::kRadioBurst, "radio.burst"},
    {FaultKind::kRadioRate, "radio.rate"},
    {FaultKind::kRadioDelay, "radio.delay"},
});

/// What "=..." behind a name may be, and what goes without saying.
struct ValueRule {
  FaultKind kind;
  double least, most, usual;
  const char* meaning;
};
constexpr std::array<ValueRule, 6> kValueRules{{
    {FaultKind::kCameraMiss, 0.0, 1.0, 1.0, "a share of 0 to 1"},
    {FaultKind::kCameraDouble, 0.0, 1.0, 1.0, "a share of 0 to 1"},
    {FaultKind::kRadioLoss, 0.0, 1.0, 0.3, "a share of 0 to 1"},
    {FaultKind::kRadioBurst, 0.0, 0.99, 0.3, "a share of 0 to 0.99"},
    {FaultKind::kRadioRate, 100.0, 1e10, 64e3, "100 to 1e10 bits per second"},
    {FaultKind::kRadioDelay, 0.0, 3600.0, 1.0, "0 to 3600 seconds"},
}};

tl::unexpected<core::Error> Wrong(std::string_view item, const std::string& what) {
  return core::Fail(
      core::ErrorCode::kInvalidArgument,
      "fault '" + std::string(item) + "': " + what + "; expected e.g. \"t=30 gps.unplug 5s\"");
}

std::vector<std::string_view> SplitWords(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = text.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return words;
    text.remove_prefix(begin);
    const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

std::optional<double> ParseNumber(std::string_view word, double least, double most) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  if (!(number >= least && number <= most)) return std::nullopt;
  return number;
}

/// A number of seconds in [0, kLatest_s], with or without a trailing 's'.
std::optional<core::Duration> ParseSeconds(std::string_view word) {
  if (!word.empty() && word.back() == 's') word.remove_suffix(1);
  const auto seconds = ParseNumber(word, 0.0, kLatest_s);
  if (!seconds) return std::nullopt;
  return core::DurationFromSeconds(*seconds);
}

/// "radio.loss=0.3" into kind and value.
core::Expected<void> ParseKind(std::string_view item, std::string_view word, Fault& fault) {
  const std::size_t equals = std::min(word.find('='), word.size());
  const std::string_view name = word.substr(0, equals);
  const auto* const named = std::find_if(kNames.begin(), kNames.end(),
                                         [&](const auto& entry) { return name == entry.second; });
  if (named == kNames.end())
    return Wrong(item, "'" + std::string(name) + "' is none of " + AllFaultNames());
  fault.kind = named->first;
  const auto* const rule =
      std::find_if(kValueRules.begin(), kValueRules.end(),
                   [&](const ValueRule& entry) { return entry.kind == fault.kind; });
  if (rule == kValueRules.end()) {
    if (equals < word.size()) return Wrong(item, "'" + std::string(name) + "' takes no value");
    return {};
  }
  fault.value = rule->usual;
  if (equals == word.size()) return {};
  const auto value = ParseNumber(word.substr(equals + 1), rule->least, rule->most);
  if (!value) return Wrong(item, "'" + std::string(word) + "' must have " + rule->meaning);
  fault.value = *value;
  return {};
}

core::Expected<Fault> ParseOne(std::string_view item) {
  const std::vector<std::string_view> words = SplitWords(item);
  if (words.size() < 2 || words.size() > 3)
    return Wrong(item, "has " + std::to_string(words.size()) + " words");
  Fault fault;
  const auto begin = words[0].starts_with("t=") ? ParseSeconds(words[0].substr(2)) : std::nullopt;
  if (!begin) return Wrong(item, "'" + std::string(words[0]) + "' is no time from the start");
  fault.begin = *begin;
  if (auto kind = ParseKind(item, words[1], fault); !kind) return tl::unexpected(kind.error());
  const auto length =
      words.size() == 3 ? ParseSeconds(words[2]) : core::DurationFromSeconds(kDefaultLength_s);
  if (!length || length->count() == 0)
    return Wrong(item, "'" + std::string(words[2]) + "' is no length of time");
  fault.length = *length;
  return fault;
}

}  // namespace

std::string AllFaultNames() {
  std::string names;
  for (const auto& [kind, name] : kNames) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

bool HasValue(FaultKind kind) {
  return std::any_of(kValueRules.begin(), kValueRules.end(),
                     [&](const ValueRule& rule) { return rule.kind == kind; });
}

bool IsRadioFault(FaultKind kind) { return kind >= FaultKind::kRadioDown; }

const char* ToString(FaultKind kind) {
  for (const auto& [known, name] : kNames) {
    if (known == kind) return name;
  }
  return "?";
}

core::Expected<std::vector<Fault>> ParseFaults(std::string_view text) {
  std::vector<Fault> faults;
  while (true) {
    const std::size_t semicolon = text.find(';');
    core::Expected<Fault> fault = ParseOne(text.substr(0, semicolon));
    if (!fault) return tl::unexpected(fault.error());
    faults.push_back(*fault);
    if (semicolon == std::string_view::npos) return faults;
    text.remove_prefix(semicolon + 1);
  }
}

bool FaultPlan::Active(FaultKind kind, core::Duration since_start) const {
  return std::any_of(faults_.begin(), faults_.end(), [&](const Fault& fault) {
    return fault.kind == kind && fault.Covers(since_start);
  });
}

std::optional<double> FaultPlan::Value(FaultKind kind, core::Duration since_start) const {
  const auto last = std::find_if(faults_.rbegin(), faults_.rend(), [&](const Fault& fault) {
    return fault.kind == kind && fault.Covers(since_start);
  });
  if (last == faults_.rend()) return std::nullopt;
  return last->value;
}

}  // namespace kawara::sim
