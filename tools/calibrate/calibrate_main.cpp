// kawara-calibrate: a camera's numbers from pictures of a chessboard, its mounting from a drive.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/geodesy.hpp"
#include "tools/calibrate/board_run.hpp"
#include "tools/calibrate/mounting_run.hpp"

namespace {

int Fail(const std::string& message, int status) {
  std::fprintf(stderr, "kawara-calibrate: %s\n", message.c_str());
  return status;
}

void Say(const std::string& text) { std::fprintf(stderr, "kawara-calibrate: %s\n", text.c_str()); }

int StatusOf(kawara::core::ErrorCode code) {
  using kawara::core::ErrorCode;
  return code == ErrorCode::kInvalidArgument || code == ErrorCode::kNotFound ? 2 : 1;
}

int Board(const kawara::calibrate::BoardOptions& options) {
  const auto result = kawara::calibrate::RunBoard(options, Say);
  if (!result) return Fail(result.error().message, StatusOf(result.error().code));
  const auto& camera = result->camera;
  std::printf("%zu of %d pictures show the board, %zu corners, %d left out\n", result->views,
              result->pictures, result->corners, camera.left_out);
  std::printf(
      "model %s: residuals %.3f px rms, of pictures it was not fitted to %.3f px rms, directions "
      "to "
      "%.3f px (1 sigma) at the worst\n",
      NameOf(camera.model).c_str(), camera.fit.rms_px, camera.cross_validated_px,
      camera.projection_sd_px);
  for (const auto& number : camera.numbers) {
    std::printf("  %-12s %14.8g +- %.2g\n", number.name.c_str(), number.value, number.sd);
  }
  std::printf("%s\n", options.out.c_str());
  if (!options.report.empty()) std::printf("%s\n", options.report.c_str());
  return 0;
}

int Mounting(const kawara::calibrate::MountingOptions& options) {
  const auto result = kawara::calibrate::RunMounting(options, Say);
  if (!result) return Fail(result.error().message, StatusOf(result.error().code));
  const Eigen::Vector3d turn = result->turn_rad / kawara::core::kRadFromDeg;
  const Eigen::Vector3d sd = result->turn_sd_rad / kawara::core::kRadFromDeg;
  std::printf(
      "%d frames over %.1f m: turned by %.3f %.3f %.3f deg (+- %.3f %.3f %.3f) about the body's "
      "axes, pictures %.1f ms (+- %.1f) after their stamps, corners fit to %.2f px\n%s\n",
      result->frames, result->way_m, turn.x(), turn.y(), turn.z(), sd.x(), sd.y(), sd.z(),
      1e3 * result->time_offset_s, 1e3 * result->time_offset_sd_s, result->residual_px,
      options.out.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "A camera's calibration: its optics from pictures of a chessboard, its mounting from a "
      "drive."};
  app.require_subcommand(1);
  kawara::calibrate::BoardOptions board;
  CLI::App* sub = app.add_subcommand("board", "Model and numbers from a folder of pictures");
  sub->add_option("PICTURES", board.folder, "Folder of .jpg and .png files, 20 to 40 are good")
      ->required();
  sub->add_option("--board", board.board, "COLSxROWS inner corners, where four squares meet")
      ->required();
  sub->add_option("--square", board.square_m, "A square's side [m]")
      ->required()
      ->check(CLI::Range(1e-4, 10.0));
  sub->add_option("--model", board.model,
                  "doughnut, doughnut-corrected, ocam, mei, ds, eucm, kb; auto: the one with the "
                  "fewest numbers of those that explain other pictures best")
      ->capture_default_str();
  sub->add_option("--axis", board.axis,
                  "Where the picture's middle looks: forward, up, down; without it up for a "
                  "doughnut, else forward");
  sub->add_flag("--mirrored", board.mirrored,
                "The picture is a mirror image (a flat board cannot tell)");
  sub->add_option("--inner", board.inner_px, "Radius of the picture's inner circle [px]")
      ->check(CLI::Range(0.0, 1e5));
  sub->add_option("--outer", board.outer_px, "Radius of the picture's outer circle [px]")
      ->check(CLI::Range(1.0, 1e5));
  sub->add_option("--out,-o", board.out, "camera.yaml to write")->required();
  sub->add_option("--report", board.report, "HTML page with residual plots");
  kawara::calibrate::MountingOptions mounting;
  CLI::App* drive = app.add_subcommand(
      "mounting", "How the camera is turned against the body, from a survey folder's drive");
  drive->add_option("SURVEY", mounting.survey, "Folder of pictures, poses and camera.yaml")
      ->required();
  drive->add_option("--out,-o", mounting.out, "mounting.yaml to write")->required();
  drive->add_option("--step", mounting.step_m, "Metres between frames that are used")
      ->check(CLI::Range(0.05, 1.5))
      ->capture_default_str();
  drive
      ->add_option("--believed", mounting.believed_deg,
                   "How well camera.yaml's mounting is known, each axis, 1 sigma [deg]")
      ->check(CLI::Range(0.01, 5.0))
      ->capture_default_str();
  drive
      ->add_option("--wanted", mounting.wanted_sd_deg,
                   "A turn known worse than this is refused, 1 sigma [deg]")
      ->check(CLI::Range(0.001, 5.0))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-calibrate --help tells more)", 2);
  }
  const int status = sub->parsed() ? Board(board) : Mounting(mounting);
  if (std::fflush(stdout) != 0) return Fail("cannot write to standard output: disk full?", 1);
  return status;
}
