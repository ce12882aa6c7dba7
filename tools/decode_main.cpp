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
  const std::map<std::string, Decoder> decoders {
    {"gps", &DecodeGps},
#if __has_include("tools/decode_ahrs.cpp")
        {"ahrs", &DecodeAhrs},
#endif
#if __has_include("tools/decode_sick.cpp")
        {"sick", &DecodeSick},
#endif
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
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return Fail(std::string(e.what()) + " (kawara-decode --help tells more)");
  }

  const auto decoder = decoders.find(kind);
  if (decoder == decoders.end()) return Fail("--as " + kind + ": not built into this program");
  auto source = ByteSource::Open(path);
  if (!source) return Fail(source.error().message);
  JsonLines out(stdout);
  const int status = decoder->second(*source, out, options);
  if (!out.Flush()) return Fail("cannot write to standard output: disk full?");
  if (source->error()) return Fail(source->error()->message);
  return status;
}
