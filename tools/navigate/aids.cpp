#include "tools/navigate/aids.hpp"

#include <algorithm>
#include <utility>

namespace kawara::navigate {
namespace {

constexpr core::Duration kSameEpoch = core::Milliseconds(1);

bool IsHeldOut(const std::vector<core::GpsTime>& epochs, core::GpsTime t) {
  const auto first = std::ranges::lower_bound(epochs, t - kSameEpoch);
  return first != epochs.end() && *first <= t + kSameEpoch;
}

std::optional<std::size_t> WindowAt(const std::vector<TimeWindow>& windows, core::GpsTime t) {
  const auto found = std::ranges::find_if(windows, [t](const auto& w) { return w.Contains(t); });
  if (found == windows.end()) return std::nullopt;
  return static_cast<std::size_t>(found - windows.begin());
}

/// Returns how many epochs were held out.
std::int64_t AddGnss(const GnssFile& file, const std::vector<core::GpsTime>& held_out,
                     bool use_arrival_times, Aids& aids) {
  std::int64_t count = 0;
  for (const GnssRow& row : file.rows) {
    const auto window = WindowAt(aids.blanks, row.fix.time);
    const bool withheld = IsHeldOut(held_out, row.fix.time);
    count += withheld ? 1 : 0;
    if (row.fix.has_position) {
      Reference reference{row.fix.time, row.fix.antenna, row.fix.rtk};
      if (window) {
        reference.role = Reference::Role::kBlanked;
        reference.window = *window;
      } else if (withheld) {
        reference.role = Reference::Role::kHeldOut;
      }
      aids.references.push_back(reference);
    }
    if (window || withheld) continue;
    const core::GpsTime given = use_arrival_times ? row.received : row.fix.time;
    if (row.fix.has_position) aids.given.push_back({given, row.fix});
    if (row.heading) aids.given.push_back({given, *row.heading});
  }
  return count;
}

template <class File>
void AddSamples(File file, Aids& aids) {
  for (auto& sample : file.rows) aids.given.push_back({sample.time, sample});
  aids.reports.push_back(std::move(file.report));
}

}  // namespace

core::Expected<Aids> ReadAids(const AidFiles& files) {
  Aids aids;
  std::vector<core::GpsTime> held_out;
  if (!files.blank.empty()) {
    auto windows = ReadWindows(files.blank, files.blank_run);
    if (!windows) return tl::unexpected(windows.error());
    aids.blanks = std::move(windows->rows);
    aids.reports.push_back(std::move(windows->report));
  }
  if (!files.hold_out.empty()) {
    auto epochs = ReadEpochs(files.hold_out);
    if (!epochs) return tl::unexpected(epochs.error());
    held_out = std::move(epochs->rows);
    aids.reports.push_back(std::move(epochs->report));
  }
  if (!files.gnss.empty()) {
    auto gnss = ReadGnss(files.gnss, files.use_arrival_times);
    if (!gnss) return tl::unexpected(gnss.error());
    const std::int64_t count = AddGnss(*gnss, held_out, files.use_arrival_times, aids);
    if (count == 0 && !held_out.empty()) {
      return core::Fail(core::ErrorCode::kInvalidArgument, files.hold_out + ": none of its " +
                                                               std::to_string(held_out.size()) +
                                                               " epochs is in " + files.gnss);
    }
    aids.reports.push_back(std::move(gnss->report));
  }
  if (!files.odometry.empty()) {
    auto odometry = ReadOdometry(files.odometry);
    if (!odometry) return tl::unexpected(odometry.error());
    AddSamples(std::move(*odometry), aids);
  }
  if (!files.attitude.empty()) {
    auto attitude = ReadAttitude(files.attitude);
    if (!attitude) return tl::unexpected(attitude.error());
    AddSamples(std::move(*attitude), aids);
  }
  std::ranges::stable_sort(aids.given, {}, &Aid::given);
  std::ranges::stable_sort(aids.references, {}, &Reference::time);
  return aids;
}

}  // namespace kawara::navigate
