#include "tools/navigate/navigate.hpp"

#include <cstdio>
#include <memory>

#include "estimation/sensor_profile.hpp"
#include "tools/navigate/log_recording.hpp"
#include "tools/navigate/merge.hpp"
#include "tools/navigate/progress.hpp"
#include "tools/navigate/report_page.hpp"

namespace kawara::navigate {
namespace {

/// Everything that is read, wherever it comes from.
struct Input {
  NextImu next_imu;
  std::function<double()> progress;       ///< 0..1 of the inertial samples
  std::function<CsvReport()> imu_report;  ///< after the last of them
  Aids aids;
  std::string name;  ///< for the report
};

void Remark(const std::string& line) {
  std::fprintf(stderr, "kawara-navigate: %s\n", line.c_str());
}

core::Expected<Input> OpenCsv(const Options& options) {
  Input input;
  input.name = options.imu;
  auto opened = ImuFile::Open(options.imu);
  if (!opened) return tl::unexpected(opened.error());
  auto aids = ReadAids(options.aids, options.withheld);
  if (!aids) return tl::unexpected(aids.error());
  input.aids = std::move(*aids);
  const auto imu = std::make_shared<ImuFile>(std::move(*opened));
  input.next_imu = [imu] { return imu->Next(); };
  input.progress = [imu] { return imu->progress(); };
  input.imu_report = [imu] { return imu->report(); };
  return input;
}

core::Expected<Input> OpenLog(const Options& options, estimation::NavigationConfig& navigation) {
  Input input;
  input.name = options.logs.front();
  auto read = ReadLog(options.logs, options.config);
  if (!read) return tl::unexpected(read.error());
  for (const std::string& remark : read->remarks) Remark(remark);
  const estimation::NavigationConfig asked = navigation;
  navigation = read->navigation;
  if (!options.lever.empty()) navigation.lever_arm_frd_m = asked.lever_arm_frd_m;
  if (!options.sensor.empty()) navigation.imu = asked.imu;
  if (options.constraint == "off") navigation.constraint = asked.constraint;
  auto aids = MakeAids(options.withheld, read->gnss, std::move(read->attitudes));
  if (!aids) return tl::unexpected(aids.error());
  input.aids = std::move(*aids);
  struct Samples {
    std::vector<estimation::ImuSample> imu;
    std::size_t next = 0;
  };
  const auto samples = std::make_shared<Samples>(Samples{std::move(read->imu)});
  input.next_imu = [samples]() -> core::Expected<std::optional<estimation::ImuSample>> {
    if (samples->next == samples->imu.size()) return std::optional<estimation::ImuSample>();
    return std::optional(samples->imu[samples->next++]);
  };
  input.progress = [samples] {
    return static_cast<double>(samples->next) / static_cast<double>(samples->imu.size());
  };
  input.imu_report = [] { return CsvReport(); };
  return input;
}

ScoreSummary ScoreOf(const ReferenceErrors& errors, const std::vector<TimeWindow>& blanks) {
  return {errors.HeldOut(core::RtkState::kFixed), errors.HeldOut(core::RtkState::kFloat),
          errors.held_out_uncovered(), errors.Blanked(blanks)};
}

RunSummary Summarise(const NavigationRun& run, const Options& options, const Input& input) {
  RunSummary summary = run.Summary();
  summary.wheels = !options.aids.odometry.empty();
  summary.scored = !options.withheld.hold_out.empty() || !options.withheld.blank.empty();
  summary.real_time = ScoreOf(run.errors(), input.aids.blanks);
  if (run.smoothed_errors() != nullptr) {
    summary.smoothed = ScoreOf(*run.smoothed_errors(), input.aids.blanks);
  }
  summary.bad_rows = input.imu_report().bad_rows;
  for (const CsvReport& report : input.aids.reports) summary.bad_rows += report.bad_rows;
  return summary;
}

void Tell(const CsvReport& report) {
  for (const std::string& line : report.Lines()) Remark(line);
}

core::Expected<void> WriteReport(const std::string& path, const std::string& page) {
  auto file = SafeFile::Create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto ok = file->Write(page); !ok) return ok;
  return file->Commit();
}

}  // namespace

tl::expected<void, Failure> Navigate(const Options& options) {
  const auto asked = [](const core::Error& error) {
    return tl::unexpected(Failure{2, error.message});
  };
  const auto unwritten = [](const core::Error& error) {
    return tl::unexpected(Failure{1, error.message});
  };
  const core::MonoTime start = core::MonoNow();
  auto run_options = RunOptionsOf(options);
  if (!run_options) return asked(run_options.error());
  auto input = options.logs.empty() ? OpenCsv(options) : OpenLog(options, run_options->navigation);
  if (!input) return asked(input.error());
  for (const CsvReport& report : input->aids.reports) Tell(report);
  auto trajectory = TrajectoryFile::Create(options.out);
  if (!trajectory) return unwritten(trajectory.error());

  NavigationRun run(*run_options, input->aids.references, *trajectory);
  bool write_failed = false;
  {
    Progress progress;
    const auto merged = Merge(input->next_imu, input->aids.given,
                              {[&](const estimation::ImuSample& sample) {
                                 progress.Tick(input->progress);
                                 auto ok = run.AddImu(sample);
                                 write_failed = !ok;
                                 return ok;
                               },
                               [&](const Aid& aid) { run.AddAid(aid); }});
    if (!merged) return write_failed ? unwritten(merged.error()) : asked(merged.error());
  }
  Tell(input->imu_report());
  if (auto ok = run.Finish(); !ok) return unwritten(ok.error());
  if (auto ok = trajectory->Commit(); !ok) return unwritten(ok.error());

  RunSummary summary = Summarise(run, options, *input);
  summary.total_s = core::ToSeconds(core::MonoNow() - start);
  if (!options.plot.empty()) {
    const auto ok = WriteReport(
        options.plot, ReportPage(run.plot(), input->aids.blanks, "Navigation over " + input->name,
                                 SummaryTable(summary)));
    if (!ok) return unwritten(ok.error());
  }
  const std::string text = options.json ? SummaryJson(summary) : SummaryTable(summary);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    return tl::unexpected(Failure{1, "cannot write to standard output: disk full?"});
  }
  return {};
}

}  // namespace kawara::navigate
