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
std::int64_t AddEpochs(const std::vector<GnssRow>& epochs,
                       const std::vector<core::GpsTime>& held_out, Aids& aids) {
  std::int64_t count = 0;
  for (const GnssRow& row : epochs) {
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
    if (row.fix.has_position || row.fix.has_velocity) aids.given.push_back({row.received, row.fix});
    if (row.heading) aids.given.push_back({row.received, *row.heading});
  }
  return count;
}

/// Adds a file's samples; its report goes to `reports`.
template <class File>
void AddSamples(File file, std::vector<Aid>& aids, std::vector<CsvReport>& reports) {
  for (auto& sample : file.rows) aids.push_back({sample.time, sample});
  reports.push_back(std::move(file.report));
}

}  // namespace

core::Expected<Aids> MakeAids(const WithheldFiles& withheld, const std::vector<GnssRow>& epochs,
                              std::vector<Aid> others) {
  Aids aids;
  std::vector<core::GpsTime> held_out;
  if (!withheld.blank.empty()) {
    auto windows = ReadWindows(withheld.blank, withheld.blank_run);
    if (!windows) return tl::unexpected(windows.error());
    aids.blanks = std::move(windows->rows);
    aids.reports.push_back(std::move(windows->report));
  }
  if (!withheld.hold_out.empty()) {
    auto listed = ReadEpochs(withheld.hold_out);
    if (!listed) return tl::unexpected(listed.error());
    held_out = std::move(listed->rows);
    aids.reports.push_back(std::move(listed->report));
  }
  if (AddEpochs(epochs, held_out, aids) == 0 && !held_out.empty()) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      withheld.hold_out + ": none of its " + std::to_string(held_out.size()) +
                          " epochs is among those of the receiver");
  }
  aids.given.insert(aids.given.end(), others.begin(), others.end());
  std::ranges::stable_sort(aids.given, {}, &Aid::given);
  std::ranges::stable_sort(aids.references, {}, &Reference::time);
  return aids;
}

core::Expected<Aids> ReadAids(const AidFiles& files, const WithheldFiles& withheld) {
  std::vector<CsvReport> reports;
  std::vector<Aid> others;
  auto gnss = ReadGnss(files.gnss, files.use_arrival_times);
  if (!gnss) return tl::unexpected(gnss.error());
  reports.push_back(std::move(gnss->report));
  if (!files.use_arrival_times) {
    for (GnssRow& row : gnss->rows) row.received = row.fix.time;
  }
  if (!files.odometry.empty()) {
    auto odometry = ReadOdometry(files.odometry);
    if (!odometry) return tl::unexpected(odometry.error());
    AddSamples(std::move(*odometry), others, reports);
  }
  if (!files.attitude.empty()) {
    auto attitude = ReadAttitude(files.attitude);
    if (!attitude) return tl::unexpected(attitude.error());
    AddSamples(std::move(*attitude), others, reports);
  }
  auto aids = MakeAids(withheld, gnss->rows, std::move(others));
  if (!aids) return aids;
  aids->reports.insert(aids->reports.begin(), reports.begin(), reports.end());
  return aids;
}

}  // namespace kawara::navigate
