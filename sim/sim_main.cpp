#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <optional>
#include <utility>

#include "core/config/config.hpp"
#include "sim/drive_run.hpp"
#include "sim/radio_run.hpp"
#include "sim/sim_options.hpp"
#include "sim/site_run.hpp"
#include "sim/survey.hpp"

namespace {

namespace sim = kawara::sim;

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void RequestStop(int /*signal*/) { stop_requested = true; }

int Fail(const kawara::core::Error& error) {
  std::fprintf(stderr, "kawara-sim: %s\n", error.message.c_str());
  return 2;
}

kawara::core::Expected<std::vector<sim::Fault>> FaultsOf(const std::vector<std::string>& texts) {
  std::vector<sim::Fault> all;
  for (const std::string& text : texts) {
    const auto faults = sim::ParseFaults(text);
    if (!faults) return tl::unexpected(faults.error());
    all.insert(all.end(), faults->begin(), faults->end());
  }
  return all;
}

/// What the options say in a form the instruments want.
kawara::core::Expected<void> Finish(sim::InstrumentOptions& o,
                                    const std::vector<std::string>& fault_texts) {
  o.ahrs.ranges.force_g = o.ahrs.ranges.rate_degps / 50.0;
  auto faults = FaultsOf(fault_texts);
  if (!faults) return tl::unexpected(faults.error());
  o.faults = std::move(*faults);
  for (const sim::Fault& fault : o.faults) {
    if (!sim::IsRadioFault(fault.kind)) continue;
    return kawara::core::Fail(kawara::core::ErrorCode::kInvalidArgument,
                              std::string("fault ") + sim::ToString(fault.kind) +
                                  " is the radio's: give it to kawara-sim radio");
  }
  return {};
}

/// Virtual time, if it was asked for.
kawara::core::Expected<std::optional<sim::VirtualTime>> VirtualTimeOf(
    const sim::InstrumentTexts& texts, const sim::InstrumentOptions& instruments) {
  if (texts.virtual_log.empty()) return std::nullopt;
  if (texts.onboard_config.empty()) {
    return kawara::core::Fail(kawara::core::ErrorCode::kInvalidArgument,
                              "--virtual needs the robot's --onboard-config FILE, e.g. "
                              "configs/survey_robot.yaml");
  }
  if (instruments.lcm_url) {
    return kawara::core::Fail(kawara::core::ErrorCode::kInvalidArgument,
                              "--virtual has no present in which --lcm-url could order faults: "
                              "order them with --fault");
  }
  auto onboard = kawara::core::config::Load<kawara::onboard::OnboardConfig>(texts.onboard_config,
                                                                            texts.onboard_set);
  if (!onboard) return tl::unexpected(onboard.error());
  return sim::VirtualTime{texts.virtual_log, std::move(*onboard)};
}

int RunRadio(sim::RadioRunOptions& options, const std::vector<std::string>& fault_texts) {
  auto faults = FaultsOf(fault_texts);
  if (!faults) return Fail(faults.error());
  options.faults = std::move(*faults);
  options.relay.up = options.relay.down;
  const auto summary = sim::RunRadio(options, stop_requested);
  if (!summary) return Fail(summary.error());
  std::printf("kawara-sim: %s\n", summary->ToText().c_str());
  return 0;
}

int Tell(const kawara::core::Expected<sim::InstrumentSummary>& summary) {
  if (!summary) return Fail(summary.error());
  std::printf("%s\n", summary->ToText().c_str());
  return 0;
}

/// 0 taken, 1 refused, 2 it reached nobody.
int SendFault(const sim::FaultCommandOptions& o) {
  const auto answer =
      sim::SendFaultOrder(o.lcm_url, o.channel, o.text,
                          kawara::core::DurationFromSeconds(o.patience_s), stop_requested);
  if (!answer) return Fail(answer.error());
  std::fprintf(answer->taken ? stdout : stderr, "kawara-sim: %s: %s\n",
               answer->taken ? "taken" : "refused", answer->text.c_str());
  return answer->taken ? 0 : 1;
}

int RunSurvey(const sim::SiteWorldOptions& where, const sim::SurveyOptions& options) {
  const auto world = sim::SiteWorld::Create(where);
  if (!world) return Fail(world.error());
  const auto summary = sim::RenderSurvey(**world, options, stop_requested);
  if (!summary) return Fail(summary.error());
  std::printf("kawara-sim: %d frames over %.1f m in %s, %.2f s a frame\n", summary->frames,
              summary->way_m, options.folder.c_str(), summary->seconds_a_frame);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "A robot that does not exist: real instruments on pseudo-terminals, with the truth.");
  app.require_subcommand(0, 1);
  sim::DriveOptions drive_options;
  sim::SiteRunOptions site_options;
  sim::SiteWorldOptions survey_world;
  sim::SurveyOptions survey_options;
  sim::InstrumentTexts texts;
  CLI::App& drive = *app.add_subcommand("drive", "replay a recorded drive at true pace");
  sim::AddDriveOptions(drive, drive_options, texts);
  CLI::App& site =
      *app.add_subcommand("site", "drive through a simulated site, with pictures of it");
  sim::AddSiteOptions(site, site_options, texts);
  sim::RadioRunOptions radio_options;
  CLI::App& radio =
      *app.add_subcommand("radio", "carry the LCM bus of a robot to a base across a bad radio");
  sim::AddRadioOptions(radio, radio_options, texts.faults);
  sim::FaultCommandOptions fault_options;
  CLI::App& fault = *app.add_subcommand("fault", "order a fault of a simulator that is running");
  sim::AddFaultCommandOptions(fault, fault_options);
  app.add_option("--render", survey_options.folder,
                 "drive through a simulated site as fast as it can be drawn, into this folder")
      ->group("Survey folder");
  CLI::App& survey = *app.add_option_group("Survey", "with --render");
  sim::AddSurveyOptions(survey, survey_world, survey_options);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty() && survey_options.folder.empty()) {
      throw CLI::RequiredError("drive, site, radio, fault or --render");
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
  if (!survey_options.folder.empty()) return RunSurvey(survey_world, survey_options);
  if (radio.parsed()) return RunRadio(radio_options, texts.faults);
  if (fault.parsed()) return SendFault(fault_options);
  sim::InstrumentOptions& instruments =
      drive.parsed() ? drive_options.instruments : site_options.instruments;
  if (const auto finished = Finish(instruments, texts.faults); !finished) {
    return Fail(finished.error());
  }
  auto virtual_time = VirtualTimeOf(texts, instruments);
  if (!virtual_time) return Fail(virtual_time.error());
  if (*virtual_time && (*virtual_time)->onboard.camera.source == "none")
    site_options.camera = false;  // nothing is drawn that nobody looks at
  drive_options.virtual_time = site_options.virtual_time = std::move(*virtual_time);
  if (drive.parsed()) return Tell(sim::RunDrive(drive_options, stop_requested));
  return Tell(sim::RunSite(site_options, stop_requested));
}
