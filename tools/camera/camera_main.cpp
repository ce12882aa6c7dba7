// kawara-camera: shows cameras, their modes and controls; takes pictures and measures streams.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tools/camera/camera_commands.hpp"

namespace {

int Fail(const std::string& message) {
  std::fprintf(stderr, "kawara-camera: %s\n", message.c_str());
  return 2;
}

void AddModeOptions(CLI::App* sub, kawara::tools::CameraOptions& options) {
  sub->add_option("--size", options.size, "WIDTHxHEIGHT; without it the largest at the rate");
  sub->add_option("--rate", options.rate_hz, "Frames a second, at least")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  sub->add_option("--format", options.format,
                  "One of " + kawara::drivers::V4l2PixelFormatNames() +
                      "; without it the first of these that is there");
  sub->add_option("--set", options.settings, "Control to set first: NAME=VALUE (several)");
  sub->add_option("--exposure", options.exposure_s,
                  "Exposure [s], where the camera does not tell its own");
  sub->add_option("--readout", options.readout_s, "End of exposure to end of frame [s]");
  sub->add_option("--patience", options.patience_s, "Seconds to wait for a frame")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

}  // namespace

int main(int argc, char** argv) {
  using namespace kawara::tools;
  CLI::App app{"A camera of this computer (V4L2) by hand, with the robot's own driver."};
  app.require_subcommand(1);
  CameraOptions options;
  std::string file;
  std::vector<std::string> settings;
  int skip = 5, count = 100;
  bool quiet = false;
  const auto command = [&](const char* name, const char* what) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option("--device,-d", options.device,
                    "/dev/videoN, a link of /dev/v4l/by-id, a bus (usb-...) or a camera's name; "
                    "without it the only camera there is");
    return sub;
  };
  CLI::App* list = app.add_subcommand("list", "Every video device, its formats, sizes and rates");
  CLI::App* controls = command("controls", "The controls with range and value; sets some first");
  controls->add_option("NAME=VALUE", settings, "Controls to set");
  CLI::App* grab = command("grab", "One picture into a file");
  grab->add_option("FILE", file, "NAME.jpg or NAME.png")->required();
  grab->add_option("--skip", skip, "Frames to let go by first")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  AddModeOptions(grab, options);
  CLI::App* stream = command("stream", "Frames with their stamps; gaps, rate and delays");
  stream->add_option("--count,-n", count, "How many frames")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  stream->add_flag("--quiet,-q", quiet, "Only the summary");
  AddModeOptions(stream, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-camera --help tells more)");
  }

  kawara::core::Expected<int> status = 0;
  if (list->parsed()) status = CameraList();
  if (controls->parsed()) status = CameraControls(options.device, settings);
  if (grab->parsed()) status = CameraGrab(options, file, skip);
  if (stream->parsed()) status = CameraStream(options, count, quiet);
  if (!status) return Fail(status.error().message);
  if (std::fflush(stdout) != 0) return Fail("cannot write to standard output: disk full?");
  return *status;
}
