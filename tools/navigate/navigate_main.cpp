// kawara-navigate: the robot's navigation filter over recorded data.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tools/navigate/navigate.hpp"

namespace {

int Fail(const std::string& message, int status) {
  std::fprintf(stderr, "kawara-navigate: %s\n", message.c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "RTK-GPS/INS navigation over recorded data: position, velocity and attitude at every "
      "inertial "
      "sample, with their deviations. Reads CSV files with a header, plain or .gz, times in GPS "
      "seconds of the week (or any seconds), or a log of the robot."};
  kawara::navigate::Options options;
  kawara::navigate::AddOptions(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-navigate --help tells more)", 2);
  }
  const auto done = kawara::navigate::Navigate(options);
  return done ? 0 : Fail(done.error().message, done.error().status);
}
