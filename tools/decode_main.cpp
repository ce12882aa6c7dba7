// kawara-decode: looks into a recording of an instrument, one JSON object a line for every message.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <string>

#include "tools/decode_common.hpp"

namespace {

int Fail(const std::string& message) {
  std::fprintf(stderr, "kawara-decode: %s\n", message.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace kawara::tools;
  using Decoder = int (*)(ByteSource&, JsonLines&, const DecodeOptions&);
  const std::map<std::string, Decoder> decoders{
      {"gps", &DecodeGps},
      {"ahrs", &DecodeAhrs},
      {"sick", &DecodeSick},
  };

  CLI::App app{
      "Prints every message of a recording as one JSON object a line, and a summary as the last "
      "line."};
  std::string kind;
  std::string path;
  DecodeOptions options;
  app.add_option("--as", kind, "Instrument the bytes came from")
      ->required()
      ->check(CLI::IsMember({"gps", "ahrs", "sick"}));
  app.add_option("FILE", path, "Recorded bytes; - is standard input")->required();
  app.add_flag("--summary", options.summary_only, "Print the last line alone");
  app.add_option("--receiver", options.receiver,
                 "For gps: whose codes and units, where makers disagree")
      ->check(CLI::IsMember({"nmea", "ashtech-legacy", "ashtech"}))
      ->capture_default_str();
  app.add_option("--scaling", options.scaling, "For ahrs: the unit is a -100 or a -200")
      ->check(CLI::IsMember({100, 200}))
      ->capture_default_str();
  app.add_option("--acceleration-sign", options.acceleration_sign,
                 "For ahrs: -1 reverses accelerations (units that send +1 g on z when level)")
      ->check(CLI::IsMember({1, -1}))
      ->capture_default_str();
  app.add_flag("--voltage", options.voltage,
               "For ahrs: 24-byte packets are voltages, not scaled data");
  app.add_option(
         "--range-bits", options.range_bits,
         "For sick: bits of a value that are range (8 m mode 13, 16 m 14, 32 m 15, 80 m 16)")
      ->check(CLI::Range(13, 16))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-decode --help tells more)");
  }

  const auto decoder = decoders.find(kind);  // CLI11 has checked that it is there
  auto source = ByteSource::Open(path);
  if (!source) return Fail(source.error().message);
  JsonLines out(stdout);
  const int status = decoder->second(*source, out, options);
  if (!out.Flush()) return Fail("cannot write to standard output: disk full?");
  if (source->error()) return Fail(source->error()->message);
  return status;
}
