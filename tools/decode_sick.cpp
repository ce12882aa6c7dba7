#include <algorithm>
#include <cstdio>

#include "core/geodesy.hpp"
#include "drivers/sick.hpp"
#include "tools/decode_common.hpp"

namespace kawara::tools {
namespace {

std::string Hex(std::span<const std::uint8_t> bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::uint8_t b : bytes) {
    text.push_back(kDigits[b >> 4]);
    text.push_back(kDigits[b & 0x0FU]);
  }
  return text;
}

/// One line a telegram or acknowledgement; scans with their ranges in metres.
class Printer : public drivers::SickSink {
 public:
  Printer(JsonLines& out, const drivers::SickDecoder& decoder, std::uint64_t first_offset,
          bool silent)
      : out_(out), decoder_(decoder), first_offset_(first_offset), silent_(silent) {}

  void OnMessage(const drivers::SickMessage& message) override {
    char type[16];
    std::snprintf(type, sizeof(type), "SICK.%02X", static_cast<unsigned>(message.command));
    types.Count(type);
    if (silent_) return;
    Close();
    out_.Begin(type);
    out_.Unsigned("offset", first_offset_ + decoder_.position());
    out_.Boolean("from_scanner", message.FromScanner());
    out_.Unsigned("address", message.address & 0x7FU);
    open_ = message.FromScanner() && (message.command == 0xB0 || message.command == 0xB7);
    if (open_) {
      // OnScan follows, unless the unit bits make no sense; then the next message ends this line.
      pending_data_ = Hex(message.data);
      return;
    }
    out_.Text("data", Hex(message.data));
    out_.End();
  }

  void OnScan(const drivers::SickScan& scan) override {
    if (silent_) return;
    open_ = false;
    out_.Unsigned("points", scan.size);
    out_.Number("first_angle_deg", scan.first_angle_rad * core::kDegFromRad, 4);
    if (scan.step_rad > 0.0) {
      out_.Number("step_deg", scan.step_rad * core::kDegFromRad, 4);
    } else {
      out_.Null("step_deg");
    }
    out_.Number("metres_per_count", scan.metres_per_count, 3);
    out_.OpenArray("range_m");
    bool flagged = false;
    for (std::size_t i = 0; i < scan.size; ++i) {
      out_.Number("", scan.RangeM(i), 3);
      flagged = flagged || scan.Flags(i) != 0;
    }
    out_.CloseArray();
    if (flagged) {
      out_.OpenArray("flags");
      for (std::size_t i = 0; i < scan.size; ++i) out_.Unsigned("", scan.Flags(i));
      out_.CloseArray();
    }
    out_.Unsigned("partial_index", scan.partial_index);
    out_.Unsigned("status", scan.status);
    out_.End();
  }

  void OnAcknowledge(core::MonoTime /*arrival*/, bool accepted) override {
    const char* type = accepted ? "SICK.ACK" : "SICK.NAK";
    types.Count(type);
    if (silent_) return;
    Close();
    out_.Begin(type);
    out_.Unsigned("offset", first_offset_ + decoder_.position());
    out_.End();
  }

  /// Ends the line of a scan telegram that turned out to be no scan.
  void Close() {
    if (!open_) return;
    out_.Text("data", pending_data_);
    out_.End();
    open_ = false;
  }

  TypeCounts types;

 private:
  JsonLines& out_;
  const drivers::SickDecoder& decoder_;
  std::uint64_t first_offset_;
  bool silent_;
  bool open_ = false;
  std::string pending_data_;
};

}  // namespace

int DecodeSick(ByteSource& source, JsonLines& out, const DecodeOptions& options) {
  drivers::SickConfig config;
  config.decode_requests = true;
  config.range_bits = options.range_bits;
  drivers::SickDecoder decoder(config);
  auto bytes = source.Read();  // the first block tells how many bytes of remarks there are
  Printer printer(out, decoder, source.comment_bytes(), options.summary_only);
  for (; !bytes.empty() && out.ok(); bytes = source.Read()) {
    decoder.Feed(core::MonoTime{}, bytes, printer);
  }
  decoder.Finish(printer);
  printer.Close();

  const drivers::SickStats& stats = decoder.stats();
  DecodeSummary summary;
  summary.good = stats.telegrams + stats.acks + stats.naks;
  summary.bad_checksum = stats.bad_checksum;
  summary.skipped_bytes = stats.skipped_bytes;
  summary.good_bytes = stats.telegram_bytes + stats.acks + stats.naks;
  summary.comment_bytes = source.comment_bytes();
  summary.types = printer.types;
  WriteSummary(out, summary, [&](JsonLines& json) {
    json.Unsigned("scans", stats.scans);
    json.Unsigned("bad_scans", stats.bad_scans);
  });
  return 0;
}

}  // namespace kawara::tools
