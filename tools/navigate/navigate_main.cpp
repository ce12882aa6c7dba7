// kawara-navigate: the robot's navigation filter over recorded data.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "tools/navigate/merge.hpp"
#include "tools/navigate/options.hpp"
#include "tools/navigate/progress.hpp"
#include "tools/navigate/report_page.hpp"

namespace {

using namespace kawara;
using namespace kawara::navigate;

int Fail(const std::string& message, int status = 2) {
  std::fprintf(stderr, "kawara-navigate: %s\n", message.c_str());
  return status;
}

void Tell(const CsvReport& report) {
  for (const std::string& line : report.Lines()) {
    std::fprintf(stderr, "kawara-navigate: %s\n", line.c_str());
  }
}

ScoreSummary ScoreOf(const ReferenceErrors& errors, const std::vector<TimeWindow>& blanks) {
  return {errors.HeldOut(core::RtkState::kFixed), errors.HeldOut(core::RtkState::kFloat),
          errors.held_out_uncovered(), errors.Blanked(blanks)};
}

/// Everything between reading the command line and the exit status.
int Navigate(const Options& options) {
  const core::MonoTime start = core::MonoNow();
  const auto run_options = RunOptionsOf(options);
  if (!run_options) return Fail(run_options.error().message);
  auto imu = ImuFile::Open(options.imu);
  if (!imu) return Fail(imu.error().message);
  const auto aids = ReadAids(options.aids);
  if (!aids) return Fail(aids.error().message);
  for (const CsvReport& report : aids->reports) Tell(report);
  auto trajectory = TrajectoryFile::Create(options.out);
  if (!trajectory) return Fail(trajectory.error().message, 1);

  NavigationRun run(*run_options, aids->references, *trajectory);
  std::optional<core::Error> write_error;
  const auto merged = [&] {
    Progress progress;
    return Merge(*imu, aids->given,
                 {[&](const estimation::ImuSample& sample) {
                    auto ok = run.AddImu(sample);
                    if (!ok) write_error = ok.error();
                    return ok;
                  },
                  [&](const Aid& aid) { run.AddAid(aid); }},
                 [&](const ImuFile& file) { progress.Tick([&] { return file.progress(); }); });
  }();
  if (!merged) return Fail(merged.error().message, write_error ? 1 : 2);
  Tell(imu->report());
  if (auto ok = run.Finish(); !ok) return Fail(ok.error().message, 1);
  if (auto ok = trajectory->Commit(); !ok) return Fail(ok.error().message, 1);

  RunSummary summary = run.Summary();
  summary.wheels = !options.aids.odometry.empty();
  summary.scored = !options.aids.hold_out.empty() || !options.aids.blank.empty();
  summary.real_time = ScoreOf(run.errors(), aids->blanks);
  if (run.smoothed_errors() != nullptr) {
    summary.smoothed = ScoreOf(*run.smoothed_errors(), aids->blanks);
  }
  summary.bad_rows = imu->report().bad_rows;
  for (const CsvReport& report : aids->reports) summary.bad_rows += report.bad_rows;
  summary.total_s = core::ToSeconds(core::MonoNow() - start);
  if (!options.plot.empty()) {
    auto page = SafeFile::Create(options.plot);
    if (!page) return Fail(page.error().message, 1);
    auto ok = page->Write(ReportPage(run.plot(), aids->blanks, "Navigation over " + options.imu,
                                     SummaryTable(summary)));
    if (ok) ok = page->Commit();
    if (!ok) return Fail(ok.error().message, 1);
  }
  const std::string text = options.json ? SummaryJson(summary) : SummaryTable(summary);
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    return Fail("cannot write to standard output: disk full?", 1);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "RTK-GPS/INS navigation over recorded data: position, velocity and attitude at every "
      "inertial "
      "sample, with their deviations. Files are CSV with a header, plain or .gz; times are GPS "
      "seconds of the week (or any seconds)."};
  Options options;
  AddOptions(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-navigate --help tells more)");
  }
  return Navigate(options);
}
