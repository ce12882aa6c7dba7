#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "sim/drive_run.hpp"
#include "sim/radio_run.hpp"
#include "sim/site_run.hpp"
#include "sim/survey.hpp"

namespace kawara::sim {

/// What `kawara-sim fault` can be told.
struct FaultCommandOptions {
  std::string text;
  std::string lcm_url;
  std::string channel = kDefaultFaultChannel;
  double patience_s = 5.0;
};

/// What needs a second look once all options are read.
struct InstrumentTexts {
  std::vector<std::string> faults;  ///< for ParseFaults
  std::string virtual_log;          ///< empty: real time
  std::string onboard_config;
  std::vector<std::string> onboard_set;
};

/// The options of kawara-sim's commands, grouped as --help shows them. What they bind to must
/// outlive parsing.
void AddDriveOptions(CLI::App& app, DriveOptions& o, InstrumentTexts& texts);
void AddSiteOptions(CLI::App& app, SiteRunOptions& o, InstrumentTexts& texts);
void AddRadioOptions(CLI::App& app, RadioRunOptions& o, std::vector<std::string>& faults);
void AddSurveyOptions(CLI::App& app, SiteWorldOptions& world, SurveyOptions& o);
void AddFaultCommandOptions(CLI::App& app, FaultCommandOptions& o);

/// A file of configs/ as found from the current folder or from where this program lies; the bare
/// name if neither has it, for the error message.
std::filesystem::path DefaultConfig(const std::string& name);

}  // namespace kawara::sim
