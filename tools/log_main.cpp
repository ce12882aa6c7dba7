// kawara-log: looks into recordings, cuts them, and takes them out as CSV and pictures.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tools/log_common.hpp"

namespace {

int Fail(const std::string& message) {
  std::fprintf(stderr, "kawara-log: %s\n", message.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace kawara::tools;
  CLI::App app{
      "Looks into LCM event logs, also damaged ones. LOG is a file, a folder of a recording, or "
      "several."};
  app.require_subcommand(1);
  std::vector<std::string> paths;
  bool json = false;
  CutOptions cut;
  ExportOptions exported;
  const auto command = [&](const char* name, const char* what) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option("LOG", paths, "Log files or folders")->required();
    return sub;
  };

  CLI::App* info = command("info", "Channels, types, rates, gaps and damage");
  info->add_flag("--json", json, "As one JSON object");
  CLI::App* check = command("check", "Exit status 0: whole; 1: damage found, listed");
  CLI::App* cutter = command("cut", "Copies a part into a new log; damaged events are left out");
  cutter->add_option("--from", cut.from,
                     "Begin: seconds from the log's start, or UTC (2026-07-08T06:30:12Z)");
  cutter->add_option("--to", cut.to, "End, not included");
  cutter->add_option("--out", cut.out, "The new log; must not exist")->required();
  cutter->add_option("--include", cut.include, "Only channels that match this regular expression");
  cutter->add_option("--exclude", cut.exclude, "No channels that match this regular expression");
  CLI::App* exporter = command("export", "One channel as CSV, a column for every field");
  exporter->add_option("--channel", exported.channel, "Name of the channel")->required();
  exporter->add_option("--out", exported.out, "CSV file; - is standard output")->required();
  exporter->add_option("--pictures", exported.pictures,
                       "For FRAME and PHASE1: folder for the pictures");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-log --help tells more)");
  }

  kawara::core::Expected<int> status = 0;
  if (info->parsed()) status = LogInfo(paths, json);
  if (check->parsed()) status = LogCheck(paths);
  if (cutter->parsed()) status = LogCut(paths, cut);
  if (exporter->parsed()) status = LogExport(paths, exported);
  if (!status) return Fail(status.error().message);
  if (std::fflush(stdout) != 0) return Fail("cannot write to standard output: disk full?");
  return *status;
}
