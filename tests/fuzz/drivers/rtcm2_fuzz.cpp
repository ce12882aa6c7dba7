// Bytes as a stream (messages must not depend on the split) and as the words of messages with good
// parity.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "drivers/rtcm2_decoder.hpp"
#include "drivers/rtcm2_encoder.hpp"

namespace {

using kawara::drivers::Rtcm2Decoder;
using kawara::drivers::Rtcm2Message;

void Check(bool good) {
  if (!good) std::abort();
}

std::vector<Rtcm2Message> Run(std::span<const std::uint8_t> bytes, std::size_t piece) {
  std::vector<Rtcm2Message> messages;
  Rtcm2Decoder decoder;
  std::uint64_t end = 0;
  while (!bytes.empty()) {
    auto part = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(part.size());
    while (const Rtcm2Message* m = decoder.Next(part)) {
      Check(m->stream_end - m->stream_bytes >= end && m->stream_end <= decoder.stats().bytes);
      end = m->stream_end;
      messages.push_back(*m);
    }
  }
  return messages;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  const auto whole = Run(bytes, SIZE_MAX);
  const auto pieces = Run(bytes, 1 + size % 13);
  Check(whole.size() == pieces.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Check(whole[i].type == pieces[i].type && whole[i].data == pieces[i].data &&
          whole[i].stream_end == pieces[i].stream_end);
  }

  // The same bytes as messages: first byte type, second length, then the words. Two plain ones go
  // ahead, because only a locked decoder can be immune against words that look like headers.
  kawara::drivers::Rtcm2Encoder encoder;
  std::vector<std::uint8_t> stream;
  std::vector<Rtcm2Message> sent;
  const auto send = [&](const Rtcm2Message& m) {
    const auto coded = encoder.Encode(m);
    stream.insert(stream.end(), coded.begin(), coded.end());
    sent.push_back(m);
  };
  for (int i = 0; i < 2; ++i) {
    Rtcm2Message plain;
    plain.type = 6;
    plain.data_words = 1;
    plain.sequence = static_cast<std::uint8_t>(i);
    send(plain);
  }
  for (std::size_t at = 0; at + 2 < size && sent.size() < 20;) {
    Rtcm2Message m;
    m.type = static_cast<std::uint8_t>(1 + data[at] % 64);
    m.data_words = static_cast<std::uint8_t>(data[at + 1] % 32);
    m.time_of_hour = std::chrono::milliseconds(600) * static_cast<int>(sent.size());
    at += 2;
    for (std::size_t i = 0; i < m.data_words; ++i, at += 3) {
      for (std::size_t k = 0; k < 3; ++k)
        m.data[i] = (m.data[i] << 8) | (at + k < size ? data[at + k] : 0U);
    }
    send(m);
  }
  const auto received = Run(stream, 7);
  Check(received.size() == sent.size());
  for (std::size_t i = 0; i < received.size(); ++i) {
    Check(received[i].type == sent[i].type && received[i].data == sent[i].data);
  }
  return 0;
}
