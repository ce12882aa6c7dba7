// kawara-mapper: ranges from pictures and poses.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <vector>

#include "onboard/mapper/depth_only.hpp"
#include "onboard/mapper/survey_model.hpp"

namespace {

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

/// A line that is drawn over itself, on a terminal only.
class ProgressLine {
 public:
  void Show(std::size_t done, std::size_t all) {
    if (isatty(STDERR_FILENO) == 0) return;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double rate = static_cast<double>(done) / seconds;
    std::fprintf(stderr, "\rkawara-mapper: %zu of %zu pairs, %.1f a second, %.0f s left ", done,
                 all, rate, static_cast<double>(all - done) / rate);
    if (done == all) std::fputc('\n', stderr);
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

int Model(const kawara::mapper::ModelOptions& options) {
  ProgressLine line;
  const auto result = kawara::mapper::BuildSurveyModel(
      options, [&line](std::size_t done, std::size_t all) { line.Show(done, all); });
  if (!result) return Fail(result.error().message, StatusOf(result.error().code));
  std::printf("kawara-mapper: %zu pairs in %.1f s; %zu tiles, %zu faces; %s\n", result->pairs,
              result->seconds, result->tiles, result->quads, result->vrml.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Motion stereo with omnidirectional and other wide-angle pictures whose poses are known. Of "
      "a "
      "survey folder (docs/survey_format.md): its textured 3D model as VRML97, GLB, 3D Tiles and "
      "LAS "
      "points; or, of two of its frames, the distance image."};
  kawara::mapper::DepthOptions depth;
  kawara::mapper::ModelOptions model;
  std::vector<std::string> frames;
  app.add_option("survey", depth.survey, "folder with camera.yaml, poses.csv and frames/")
      ->required();
  app.add_option("--depth-only", frames,
                 "two frames by name: only the distance image of the first, in its own pixels")
      ->expected(2)
      ->type_name("FRAME_A FRAME_B");
  app.add_option(
         "--out", depth.out,
         "folder for model.wrl, tile_X_Y.wrl and .glb, tileset.json, points.las; with "
         "--depth-only A_B.range.png (16 bits, mm, 0 unknown), A_B.sd.png (16 bits, 0.1 mm), "
         "both as .pfm (float metres, NaN unknown), and A_B.view.png for people")
      ->capture_default_str();
  app.add_option("--nearest", depth.nearest_m, "nothing nearer is looked for [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 100.0));
  app.add_flag("--given-poses{false}", depth.refine,
               "take the poses as they are, without refining them on the pictures");
  app.add_option("--px-per-rad", depth.px_per_rad,
                 "resolution of the search; 0: as the first picture's own")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 2000.0));
  app.add_option("--baseline", model.baseline_m, "of the model's pairs, at least [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 100.0));
  app.add_option("--step", model.step_m, "between the first frames of two pairs, at least [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--voxel", model.voxel_m, "of the model [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.02, 1.0));
  app.add_option("--reach", model.reach_m, "ranges beyond are not voted [m]")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 30.0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-mapper --help tells more)", 2);
  }
  if (!frames.empty()) {
    depth.frame_a = frames[0];
    depth.frame_b = frames[1];
    return DepthOnly(depth);
  }
  model.survey = depth.survey;
  model.out = depth.out;
  model.nearest_m = depth.nearest_m;
  model.px_per_rad = depth.px_per_rad;
  return Model(model);
}
