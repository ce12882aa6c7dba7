#pragma once
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/gnss_stream.hpp"

namespace kawara::testing {

using Bytes = std::vector<std::uint8_t>;

inline Bytes ToBytes(std::string_view text) { return {text.begin(), text.end()}; }

/// A whole recording of data/gnss without the remarks at its beginning. Empty if it is not there.
inline Bytes LoadRecording(const std::string& name) {
  std::ifstream file(std::string(KAWARA_SOURCE_DIR) + "/data/gnss/" + name, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::size_t begin = 0;
  while (begin < bytes.size() && bytes[begin] == '#') {
    while (begin < bytes.size() && bytes[begin] != '\n') ++begin;
    ++begin;
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(begin));
  return bytes;
}

/// "$body*cc\r\n"
inline std::string Sentence(const std::string& body) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  const std::uint8_t sum = drivers::NmeaChecksum(body);
  return "$" + body + "*" + kHex[sum >> 4] + kHex[sum & 15U] + "\r\n";
}

/// What a message was, where and when: enough to compare two decodings.
struct Found {
  std::string type;
  std::uint64_t offset = 0;
  std::int64_t arrival_ns = 0;
  std::size_t bytes = 0;
  bool invalid = false;
  bool operator==(const Found&) const = default;
};

class Collector : public drivers::GnssStreamSink {
 public:
  void OnMessage(const drivers::GnssMessage& m) override {
    found.push_back(
        {std::string(TypeName(m).view()), m.offset, m.arrival.ns(), m.bytes.size(), IsInvalid(m)});
  }
  std::size_t Count(std::string_view type) const {
    std::size_t n = 0;
    for (const Found& f : found) n += f.type == type ? 1U : 0U;
    return n;
  }
  std::vector<Found> found;
};

/// Hands every message to a function.
template <class Function>
class Each : public drivers::GnssStreamSink {
 public:
  explicit Each(Function function) : function_(function) {}
  void OnMessage(const drivers::GnssMessage& m) override { function_(m); }

 private:
  Function function_;
};

template <class Function>
drivers::GnssStreamDecoder::Stats DecodeEach(const Bytes& bytes, Function function) {
  drivers::GnssStreamDecoder decoder;
  Each<Function> sink(function);
  decoder.Feed(core::MonoTime::FromNs(1), bytes, sink);
  decoder.Finish(sink);
  return decoder.stats();
}

}  // namespace kawara::testing
