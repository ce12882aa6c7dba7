// kawara-mapper: ranges from pictures and poses.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <vector>

#include "onboard/mapper/depth_only.hpp"

namespace {

int Fail(const std::string& message, int status) {
  std::fprintf(stderr, "kawara-mapper: %s\n", message.c_str());
  return status;
}

int StatusOf(kawara::core::ErrorCode code) {
  using kawara::core::ErrorCode;
  return code == ErrorCode::kInvalidArgument || code == ErrorCode::kNotFound ? 2 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Motion stereo with omnidirectional and other wide-angle pictures whose poses are known: the "
      "distance of "
      "everything that two pictures of a survey folder (docs/survey_format.md) show, with its "
      "standard deviation."};
  kawara::mapper::DepthOptions options;
  std::vector<std::string> frames;
  app.add_option("survey", options.survey, "folder with camera.yaml, poses.csv and frames/")
      ->required();
  app.add_option("--depth-only", frames,
                 "two frames by name: the distance image of the first, in its own pixels")
      ->expected(2)
      ->required()
      ->type_name("FRAME_A FRAME_B");
  app.add_option(
         "--out", options.out,
         "folder for A_B.range.png (16 bits, mm, 0 unknown), A_B.sd.png (16 bits, 0.1 mm), both "
         "as .pfm (float metres, NaN unknown), and A_B.view.png for people")
      ->capture_default_str();
  app.add_option("--nearest", options.nearest_m, "nothing nearer is looked for [m]")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 100.0));
  app.add_option("--px-per-rad", options.px_per_rad,
                 "resolution of the search; 0: as the first picture's own")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 2000.0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-mapper --help tells more)", 2);
  }
  options.frame_a = frames[0];
  options.frame_b = frames[1];
  const auto result = kawara::mapper::RunDepthOnly(options);
  if (!result) return Fail(result.error().message, StatusOf(result.error().code));
  if (!result->warning.empty()) {
    std::fprintf(stderr, "kawara-mapper: warning: %s\n", result->warning.c_str());
  }
  std::printf(
      "kawara-mapper: baseline %.3f m; %.1f %% of the pixels known, median %.2f m +- %.3f m; %.2f "
      "s; %s\n",
      result->baseline_m, 100.0 * result->known, result->median_range_m, result->median_sd_m,
      result->seconds, result->files.range_png.c_str());
  return 0;
}
