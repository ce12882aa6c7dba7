#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/crc24q.hpp"
#include "tests/support/counting_allocator.hpp"

/// Files and small builders shared by the tests of corrections.
namespace kawara::drivers::testing {

using Bytes = std::vector<std::uint8_t>;

inline Bytes ReadRecording(const std::string& name) {
  const std::string path = std::string(KAWARA_SOURCE_DIR) + "/data/gnss/" + name;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot open " + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Writes big-endian bit fields; beyond 64 bits the sign goes on.
class BitWriter {
 public:
  BitWriter& Put(std::int64_t value, unsigned bits) {
    for (unsigned i = bits; i-- > 0;) {
      if (used_ % 8 == 0) bytes_.push_back(0);
      const auto bit = static_cast<unsigned>((value >> std::min(i, 63U)) & 1);
      bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | (bit << (7 - used_ % 8)));
      ++used_;
    }
    return *this;
  }
  BitWriter& PutText(const std::string& text) {
    Put(static_cast<std::int64_t>(text.size()), 8);
    for (const char c : text) Put(static_cast<unsigned char>(c), 8);
    return *this;
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
  std::size_t used_ = 0;
};

inline Bytes MakeRtcm3Frame(std::span<const std::uint8_t> payload, std::uint8_t reserved = 0) {
  Bytes frame{
      0xD3,
      static_cast<std::uint8_t>((static_cast<unsigned>(reserved) << 2) | (payload.size() >> 8)),
      static_cast<std::uint8_t>(payload.size() & 0xFF)};
  frame.insert(frame.end(), payload.begin(), payload.end());
  const std::uint32_t crc = Crc24q(frame);
  for (const unsigned shift : {16U, 8U, 0U})
    frame.push_back(static_cast<std::uint8_t>(crc >> shift));
  return frame;
}

inline std::span<const std::uint8_t> AsBytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}
inline void Append(Bytes& to, std::span<const std::uint8_t> more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// Cuts `bytes` into pieces of 1 .. `longest`, in a fixed pseudo-random way, and hands them over.
template <class Use>
void ForPieces(std::span<const std::uint8_t> bytes, std::size_t longest, Use use) {
  std::uint32_t random = 12345;
  while (!bytes.empty()) {
    random = random * 1664525U + 1013904223U;
    const std::size_t take = std::min<std::size_t>(bytes.size(), 1 + (random >> 16) % longest);
    use(bytes.first(take));
    bytes = bytes.subspan(take);
  }
}

using kawara::testing::AllocationsOfThisThread;

}  // namespace kawara::drivers::testing
