// kawara-mapper: ranges from pictures and poses.
#include <malloc.h>
#include <sched.h>
#include <sys/syscall.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "comms/lcm_bus.hpp"
#include "comms/log_bus.hpp"
#include "onboard/mapper/bus_source.hpp"
#include "onboard/mapper/depth_only.hpp"
#include "onboard/mapper/model_report.hpp"
#include "onboard/mapper/model_run.hpp"
#include "onboard/mapper/progress_line.hpp"
#include "onboard/mapper/survey_source.hpp"
#include "onboard/mapper/watch/change_reporter.hpp"
#include "vision/change/reference_file.hpp"

namespace {

/// Near the baseline a wrong match comes out near, surely, and in the air that the robot drives
/// through: pair by pair a voxel gets the votes of a surface there. Measured (tests/bench/stereo).
constexpr double kModelPoleCapRad = 20.0 * kawara::core::kRadFromDeg;

int Fail(const std::string& message, int status) {
  std::fprintf(stderr, "kawara-mapper: %s\n", message.c_str());
  return status;
}

int StatusOf(kawara::core::ErrorCode code) {
  using kawara::core::ErrorCode;
  return code == ErrorCode::kInvalidArgument || code == ErrorCode::kNotFound ? 2 : 1;
}

int DepthOnly(const kawara::mapper::DepthOptions& options) {
  const auto result = kawara::mapper::RunDepthOnly(options);
  if (!result) return Fail(result.error().message, StatusOf(result.error().code));
  if (!result->warning.empty()) {
    std::fprintf(stderr, "kawara-mapper: warning: %s\n", result->warning.c_str());
  }
  if (result->frames_used > 0) {
    std::printf(
        "kawara-mapper: poses refined on %d frames; the second frame moved %.1f mm and %.3f deg "
        "against the first\n",
        result->frames_used, 1e3 * result->step_change_m,
        result->step_change_rad / kawara::core::kRadFromDeg);
  }
  std::printf(
      "kawara-mapper: baseline %.3f m; %.1f %% of the pixels known, median %.2f m +- %.3f m; %.2f "
      "s; %s\n",
      result->baseline_m, 100.0 * result->known, result->median_range_m, result->median_sd_m,
      result->seconds, result->files.range_png.c_str());
  return 0;
}

std::atomic<bool> stop_asked = false;

void OnSignal(int) { stop_asked = true; }

/// What a model is made with, and what is wanted beside it.
struct ModelWishes {
  kawara::mapper::ModelOptions options;
  std::string report;     ///< file; empty: none
  std::string reference;  ///< file; empty: changes are not looked for
  std::vector<std::filesystem::path> known;
  std::string robot, mission;  ///< who looks
  /// On the bus; empty: there is none.
  kawara::comms::ObjectPublisher::Send send;
};

using Report = std::optional<kawara::mapper::ModelReport>;
using Reference = std::optional<kawara::vision::ReferenceMap>;

kawara::core::Expected<Reference> OpenReference(const ModelWishes& wishes) {
  if (wishes.reference.empty()) return Reference();
  auto reference = kawara::vision::ReadReference(wishes.reference);
  if (!reference) return tl::unexpected(reference.error());
  return Reference(std::move(*reference));
}

/// Where the map lies: as an earlier run on the same folder laid it, else as the reference's does.
std::optional<kawara::core::Geodetic> OriginOf(const ModelWishes& wishes,
                                               const Reference& reference) {
  std::optional<kawara::core::Geodetic> origin;
  if (!wishes.options.fresh) origin = kawara::mapper::ModelStore::OriginOf(wishes.options.out);
  if (!origin && reference) origin = reference->origin;
  return origin;
}

/// Refuses before the work, not after it. Empty: there is none, and none is wanted.
kawara::core::Expected<Report> OpenReport(const ModelWishes& wishes, const std::string& truth) {
  if (wishes.report.empty()) return Report();
  auto report = kawara::mapper::ModelReport::Open(wishes.report, truth);
  if (!report) return tl::unexpected(report.error());
  return Report(std::move(*report));
}

int Model(kawara::mapper::FrameSource& source, const std::string& name, bool live,
          const ModelWishes& wishes, Report report, Reference reference) {
  const kawara::mapper::ModelOptions& options = wishes.options;
  kawara::mapper::ProgressLine line;
  kawara::mapper::ModelHooks hooks;
  hooks.progress = [&](std::uint64_t stops, std::uint64_t all, std::uint64_t pairs) {
    line.Show(stops, all, pairs);
  };
  hooks.say = [&](const std::string& text) {
    line.End();
    std::fprintf(stderr, "kawara-mapper: %s\n", text.c_str());
    if (report) report->Say(text);
  };
  if (report) {
    hooks.measured = [&](const kawara::mapper::PicturePair& pair, const auto& camera,
                         const auto& ranges) { report->Measured(pair, camera, ranges); };
  }
  std::unique_ptr<kawara::mapper::ChangeReporter> changes;
  if (reference) {
    kawara::mapper::ReporterOptions reporting;
    reporting.reference = std::move(*reference);
    reporting.known = wishes.known;
    reporting.robot = wishes.robot;
    reporting.mission = wishes.mission;
    reporting.send = wishes.send;
    reporting.journal = options.out / "changes.lcm";
    reporting.fresh = options.fresh;
    reporting.origin = source.rig().origin;
    reporting.say = hooks.say;
    std::error_code error;
    std::filesystem::create_directories(options.out, error);  // RunModel says what is wrong with it
    auto opened = kawara::mapper::ChangeReporter::Open(std::move(reporting));
    if (!opened) return Fail(opened.error().message, StatusOf(opened.error().code));
    changes = std::move(*opened);
    hooks.grown = [&](const auto& grown) {
      changes->Repeat(kawara::core::MonoNow());
      return changes->OnGrown(grown);
    };
    hooks.waiting = [&] { changes->Repeat(kawara::core::MonoNow()); };
  }
  // A live source ends when it is asked to, and the model is then finished.
  if (!live) hooks.stop = &stop_asked;
  const auto result = kawara::mapper::RunModel(options, source, name, hooks);
  line.End();
  if (!result) return Fail(result.error().message, StatusOf(result.error().code));
  if (source.left_out() > 0) {
    hooks.say("warning: " + std::to_string(source.left_out()) +
              " pictures were left out: the mapper was late");
  }
  if (result->interrupted) {
    return Fail("interrupted after " + std::to_string(result->pairs) +
                    " pairs: the same command goes on from here",
                130);
  }
  if (!result->rig.empty()) std::printf("kawara-mapper: %s\n", result->rig.c_str());
  std::printf("kawara-mapper: %" PRIu64 " pairs in %.1f s; %zu tiles, %" PRIu64 " faces; %s\n",
              result->pairs, result->seconds, result->tiles, result->faces, result->vrml.c_str());
  if (changes) {
    std::printf("kawara-mapper: %zu changed objects stand (%" PRIu64 " revisions, %" PRIu64
                " pictures of sides, %" PRIu64 " road stations told; %.1f s CPU); %s\n",
                changes->objects(), changes->told(), changes->textures(), changes->stations(),
                changes->cpu_s(), (options.out / "changes.lcm").c_str());
  }
  if (!report) return 0;
  const auto written = report->Write(options, *result, source.rig(), name);
  return written ? 0 : Fail(written.error().message, 1);
}

std::string FullName(const std::string& path) {
  std::error_code error;
  const std::string full = std::filesystem::weakly_canonical(path, error).string();
  return error ? path : full;
}

int ModelOfSurvey(const std::string& folder, const ModelWishes& wishes) {
  auto reference = OpenReference(wishes);
  if (!reference) return Fail(reference.error().message, StatusOf(reference.error().code));
  auto survey = kawara::survey::OpenSurvey(folder, OriginOf(wishes, *reference));
  if (!survey) return Fail(survey.error().message, StatusOf(survey.error().code));
  auto report = OpenReport(wishes, folder);
  if (!report) return Fail(report.error().message, StatusOf(report.error().code));
  const std::string name = FullName(folder) + " (" + kawara::mapper::FingerprintOf(folder) + ")";
  kawara::mapper::SurveySource source(std::move(*survey));
  ModelWishes complete = wishes;
  complete.mission = std::filesystem::path(FullName(folder)).filename().string();
  if (complete.robot.empty()) complete.robot = "robot";
  return Model(source, name, false, complete, std::move(*report), std::move(*reference));
}

struct BusArguments {
  bool live = false;
  bool normal_priority = false;
  std::string url, robot;
  std::vector<std::string> logs;
};

kawara::core::Expected<std::unique_ptr<kawara::comms::Bus>> OpenBus(const BusArguments& args) {
  using namespace kawara::comms;  // NOLINT(google-build-using-namespace)
  if (!args.live) {
    auto reader = EventLogReader::Open({args.logs.begin(), args.logs.end()});
    if (!reader) return tl::unexpected(reader.error());
    return std::make_unique<LogBus>(std::move(*reader));
  }
  auto bus = LcmBus::Open({.url = args.url});
  if (!bus) return tl::unexpected(bus.error());
  for (const std::string& warning : (*bus)->warnings()) {
    std::fprintf(stderr, "kawara-mapper: warning: %s\n", warning.c_str());
  }
  return std::move(*bus);
}

/// The robot's real-time side comes first: this thread, and all that it starts from now on, run
/// when nobody else wants to.
void GiveWay() {
  const sched_param none{};
  (void)sched_setscheduler(0, SCHED_IDLE, &none);    // refused: harmless
  constexpr int kProcess = 1, kIdleClass = 3 << 13;  // IOPRIO_WHO_PROCESS, IOPRIO_CLASS_IDLE
  (void)syscall(SYS_ioprio_set, kProcess, 0, kIdleClass);
}

int ModelOfBus(const BusArguments& args, const ModelWishes& wishes) {
  const kawara::mapper::ModelOptions& options = wishes.options;
  auto report = OpenReport(wishes, "");
  if (!report) return Fail(report.error().message, StatusOf(report.error().code));
  auto reference = OpenReference(wishes);
  if (!reference) return Fail(reference.error().message, StatusOf(reference.error().code));
  auto bus = OpenBus(args);
  if (!bus) return Fail(bus.error().message, StatusOf(bus.error().code));
  auto source = kawara::mapper::BusSource::Open(
      std::move(*bus), {.live = args.live,
                        .step_m = options.pairs.step_m,
                        .robot = args.robot,
                        .origin = OriginOf(wishes, *reference),
                        .stop = &stop_asked,
                        .say = [](const std::string& text) {
                          std::fprintf(stderr, "kawara-mapper: %s\n", text.c_str());
                        }});
  if (!source) return Fail(source.error().message, StatusOf(source.error().code));
  // Not before: what listens to the bus costs little, and what it fetches too late is lost.
  if (args.live && !args.normal_priority) GiveWay();
  const std::string name =
      args.live ? "robot '" + (*source)->robot() + "' on the bus" : FullName(args.logs.front());
  ModelWishes complete = wishes;
  complete.robot = (*source)->robot();
  complete.mission = (*source)->mission();
  std::unique_ptr<kawara::comms::Bus> out;
  if (args.live && *reference) {
    auto opened = OpenBus(args);
    if (!opened) return Fail(opened.error().message, StatusOf(opened.error().code));
    out = std::move(*opened);
    complete.send = [&out](std::string_view channel, const std::vector<std::uint8_t>& message) {
      return out->Publish(channel, message);
    };
  }
  return Model(**source, name, args.live, complete, std::move(*report), std::move(*reference));
}

}  // namespace

int main(int argc, char** argv) {
  // Pictures go back to the system when they are done with, instead of leaving holes.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  CLI::App app{
      "Motion stereo with omnidirectional and other wide-angle pictures whose poses are known. Of "
      "a "
      "survey folder (docs/survey_format.md): its textured 3D model as VRML97, GLB, 3D Tiles and "
      "LAS "
      "points; or, of two of its frames, the distance image."};
  kawara::mapper::DepthOptions depth;
  ModelWishes wishes;
  kawara::mapper::ModelOptions& model = wishes.options;
  std::vector<std::string> frames;
  BusArguments bus;
  auto* survey =
      app.add_option("survey", depth.survey, "folder with camera.yaml, poses.csv and frames/");
  auto* log =
      app.add_option("--log", bus.logs,
                     "LCM log instead, of kawara-onboard or of the base: its PHASE1 pictures")
          ->excludes(survey);
  auto* live = app.add_flag("--live", bus.live,
                            "take the PHASE1 pictures from the bus as they come, until SIGINT or "
                            "SIGTERM")
                   ->excludes(survey)
                   ->excludes(log);
  app.add_option("--bus", bus.url, "LCM URL of --live; else LCM_DEFAULT_URL")->needs(live);
  std::string priority = "idle";
  app.add_option("--priority", priority,
                 "of --live: idle, so that the robot's real-time side never waits for it, or "
                 "normal, as on a base station")
      ->capture_default_str()
      ->check(CLI::IsMember({"idle", "normal"}))
      ->needs(live);
  app.add_option("--robot", bus.robot,
                 "with --log or --live: of several robots, this one; else who looked");
  app.add_option("--depth-only", frames,
                 "two frames by name: only the distance image of the first, in its own pixels")
      ->expected(2)
      ->type_name("FRAME_A FRAME_B");
  app.add_option(
         "--out", depth.out,
         "folder for model.wrl, tile_X_Y.wrl, .glb, .ply and .las, tileset.json, model.yaml; with "
         "--depth-only A_B.range.png (16 bits, mm, 0 unknown), A_B.sd.png (16 bits, 0.1 mm), "
         "both as .pfm (float metres, NaN unknown), and A_B.view.png for people")
      ->capture_default_str();
  app.add_option("--report", wishes.report,
                 "file for a page of HTML about the model: figures, distance images, views, and "
                 "the accuracy where the survey has true ranges (range/)")
      ->type_name("FILE");
  std::optional<double> nearest_m;
  app.add_option("--nearest", nearest_m,
                 "nothing nearer is looked for [m]; 1.5, and with --depth-only as near as there is "
                 "something")
      ->check(CLI::Range(0.05, 100.0));
  std::string method = "fast";
  app.add_option("--method", method,
                 "of stereo: fast, or paper: Meguro et al.'s, which measures colour edges only")
      ->capture_default_str()
      ->check(CLI::IsMember({"fast", "paper"}));
  app.add_flag("--given-poses{false}", depth.refine,
               "take the poses as they are, without refining them on the pictures");
  app.add_option("--px-per-rad", depth.stereo.px_per_rad,
                 "resolution of the fast method's search; 0: as the first picture's own")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 2000.0));
  std::optional<double> pole_cap_deg;
  app.add_option(
         "--pole-cap", pole_cap_deg,
         "of the fast method: directions nearer to the baseline stay unknown [deg]; 10, and "
         "of a model 20, as other pictures see better what lies there")
      ->check(CLI::Range(1.0, 60.0));
  app.add_option("--baseline", model.pairs.baseline_m, "of the model's pairs, at least [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 100.0));
  std::string baselines = "one";
  app.add_option("--baselines", baselines,
                 "of each of the model's distance images: one, or several: also the picture as far "
                 "behind and those half as far on either side; live it does with one when it is "
                 "late")
      ->capture_default_str()
      ->check(CLI::IsMember({"one", "several"}));
  app.add_option("--step", model.pairs.step_m,
                 "between the first frames of two pairs, at least [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--voxel", model.builder.voxel_m, "of the model [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.02, 1.0));
  app.add_option("--reference", wishes.reference,
                 "file of kawara-reference: what stands on its road and is not in it is told of "
                 "while the model grows, in OUT/changes.lcm and, with --live, on the bus");
  app.add_option("--known", wishes.known,
                 "changes.lcm of earlier missions: their objects keep their ids, and are closed "
                 "when they are gone")
      ->expected(1, -1);
  app.add_flag("--fresh", model.fresh,
               "make the model anew instead of going on with what is in the folder");
  app.add_option("--reach", model.builder.reach_m, "ranges beyond are not voted [m]")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 30.0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-mapper --help tells more)", 2);
  }
  const bool of_bus = bus.live || !bus.logs.empty();
  if (!of_bus && depth.survey.empty()) {
    return Fail("survey is required: a folder, or --log FILE, or --live (kawara-mapper --help)", 2);
  }
  if (!frames.empty() && of_bus) return Fail("--depth-only works on survey folders", 2);
  if (!frames.empty() && !wishes.report.empty()) {
    return Fail("--report is of a model: leave --depth-only out", 2);
  }
  wishes.robot = bus.robot;
  bus.normal_priority = priority == "normal";
  if (method == "paper") depth.stereo.method = kawara::mapper::StereoMethod::kPaper;
  model.pairs.several = baselines == "several";
  if (method == "paper" && model.pairs.several) {
    return Fail("--baselines several is of the fast method: the paper's has one", 2);
  }
  if (method == "paper" && pole_cap_deg) {
    return Fail("--pole-cap is of the fast method: the paper's has none", 2);
  }
  if (method == "paper" && depth.stereo.px_per_rad > 0.0) {
    return Fail("--px-per-rad is of the fast method: the paper's searches the picture itself", 2);
  }
  depth.find_nearest = !nearest_m;
  if (nearest_m) depth.stereo.nearest_m = *nearest_m;
  if (pole_cap_deg) depth.stereo.pole_cap_rad = *pole_cap_deg * kawara::core::kRadFromDeg;
  if (!frames.empty()) {
    depth.frame_a = frames[0];
    depth.frame_b = frames[1];
    return DepthOnly(depth);
  }
  model.out = depth.out;
  model.pairs.refine = depth.refine;
  model.builder.stereo = depth.stereo;
  if (!pole_cap_deg) model.builder.stereo.pole_cap_rad = kModelPoleCapRad;
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  return of_bus ? ModelOfBus(bus, wishes) : ModelOfSurvey(depth.survey, wishes);
}
