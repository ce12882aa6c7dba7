#include "tools/decode_gps.hpp"

#include "drivers/gnss_stream.hpp"
#include "tools/decode_common.hpp"

namespace kawara::tools {
namespace {

class Printer : public drivers::GnssStreamSink {
 public:
  Printer(JsonLines& out, std::uint64_t first_offset, drivers::ReceiverProfile profile, bool silent)
      : out_(out), first_offset_(first_offset), profile_(profile), silent_(silent) {}

  void OnMessage(const drivers::GnssMessage& message) override {
    const drivers::GnssTypeName name = TypeName(message);
    types.Count(name.view());
    if (name.view() == "PASHR") {
      const std::string_view kind = AshtechType(message.sentence);
      pashr.Count(kind.empty() ? "?" : kind);
    }
    if (silent_) return;
    out_.Begin(name.view());
    out_.Unsigned("offset", first_offset_ + message.offset);
    if (IsInvalid(message)) out_.Boolean("invalid", true);
    if (const auto* nmea = message.As<drivers::NmeaBody>()) {
      WriteText(out_, *nmea, profile_);
    } else if (const auto* ashtech = message.As<drivers::AshtechBody>()) {
      out_.Text("message", AshtechType(message.sentence));
      WriteText(out_, *ashtech, profile_);
    } else {
      WriteBinary(out_, message);
    }
    if (NeedsRaw(message)) out_.Text("fields", message.sentence.fields);
    out_.End();
  }

  TypeCounts types;
  TypeCounts pashr;

 private:
  /// Text that is not understood is shown as it came.
  static bool NeedsRaw(const drivers::GnssMessage& message) {
    return message.Nmea<drivers::NmeaOther>() != nullptr ||
           message.Nmea<drivers::NmeaInvalid>() != nullptr ||
           message.Ashtech<drivers::AshtechOther>() != nullptr ||
           message.Ashtech<drivers::AshtechInvalid>() != nullptr;
  }

  JsonLines& out_;
  std::uint64_t first_offset_;
  drivers::ReceiverProfile profile_;
  bool silent_;
};

}  // namespace

int DecodeGps(ByteSource& source, JsonLines& out, const DecodeOptions& options) {
  drivers::ReceiverProfile profile = drivers::ReceiverProfile::kNmea;
  drivers::FromString(options.receiver, profile);
  drivers::GnssStreamDecoder decoder;
  auto bytes = source.Read();  // the first block tells how many bytes of remarks there are
  Printer printer(out, source.comment_bytes(), profile, options.summary_only);
  for (; !bytes.empty() && out.ok(); bytes = source.Read())
    decoder.Feed(core::MonoTime{}, bytes, printer);
  decoder.Finish(printer);

  const drivers::GnssStreamDecoder::Stats& stats = decoder.stats();
  DecodeSummary summary;
  summary.good = stats.good;
  summary.bad_checksum = stats.bad_checksum;
  summary.skipped_bytes = stats.skipped_bytes;
  summary.good_bytes = stats.good_bytes;
  summary.bad_bytes = stats.bad_bytes;
  summary.comment_bytes = source.comment_bytes();
  summary.types = printer.types;
  WriteSummary(out, summary, [&](JsonLines& json) {
    json.Unsigned("invalid", stats.invalid);
    if (!printer.pashr.counts().empty()) printer.pashr.Write(json, "pashr");
  });
  return 0;
}

}  // namespace kawara::tools
