#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "tools/byte_source.hpp"
#include "tools/json_lines.hpp"

namespace kawara::tools {

struct DecodeOptions {
  bool summary_only = false;      ///< --summary: the last line alone
  std::string receiver = "nmea";  ///< --receiver, for gps: which encoding of quality and units
  int scaling = 100;              ///< --scaling, for ahrs: the unit's model suffix, 100 or 200
  int acceleration_sign = 1;      ///< --acceleration-sign, for ahrs: -1 reverses
  bool voltage = false;           ///< --voltage, for ahrs: 24-byte packets hold voltages
  int range_bits = 13;            ///< --range-bits, for sick: the rest of a value are flags
};

/// How often each type came. Types are bounded, so that garbage cannot make this grow: what does
/// not fit any more is counted as "other".
class TypeCounts {
 public:
  void Count(std::string_view type) {
    const auto it = counts_.find(type);
    if (it != counts_.end()) {
      ++it->second;
    } else {
      ++counts_[counts_.size() < kMaxTypes ? std::string(type) : std::string("other")];
    }
  }
  const std::map<std::string, std::uint64_t, std::less<>>& counts() const { return counts_; }
  void Write(JsonLines& out, std::string_view key) const {
    out.OpenObject(key);
    for (const auto& [type, count] : counts_) out.Unsigned(type, count);
    out.CloseObject();
  }

 private:
  static constexpr std::size_t kMaxTypes = 4096;
  std::map<std::string, std::uint64_t, std::less<>> counts_;
};

/// What the last line says. Every byte of the input is in a good message, in a bad one, skipped, or
/// a remark: good_bytes + bad_bytes + skipped_bytes + comment_bytes = total_bytes.
struct DecodeSummary {
  std::uint64_t good = 0;          ///< messages with the right checksum
  std::uint64_t bad_checksum = 0;  ///< messages with a wrong one
  std::uint64_t skipped_bytes = 0;
  std::uint64_t good_bytes = 0;
  std::uint64_t bad_bytes = 0;
  std::uint64_t comment_bytes = 0;
  TypeCounts types;
};
/// Writes {"summary": {...}}. `more` may add members inside.
void WriteSummary(JsonLines& out, const DecodeSummary& summary,
                  const std::function<void(JsonLines&)>& more = nullptr);

/// Decodes everything `source` has, one object a line into `out`, then the summary line. Memory is
/// constant. Returns the exit status (0; reading and writing errors are found by the caller in
/// `source` and `out`).
int DecodeGps(ByteSource& source, JsonLines& out, const DecodeOptions& options);
int DecodeAhrs(ByteSource& source, JsonLines& out, const DecodeOptions& options);
int DecodeSick(ByteSource& source, JsonLines& out, const DecodeOptions& options);

}  // namespace kawara::tools
