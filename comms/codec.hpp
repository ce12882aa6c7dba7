#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "comms/lcm_schema.hpp"
#include "core/expected.hpp"

namespace kawara::comms {

namespace internal {
/// The built-in type with this generated name and fingerprint; aborts if it is not one of
/// comms/lcmtypes.
const LcmType& BuiltinType(const char* name, std::int64_t fingerprint);
}  // namespace internal

/// LCM bytes of a message, fingerprint first. Errors: kInvalidArgument when an array's size and its
/// count field disagree so that the result is not a message of its type, or when it would exceed 2
/// GiB.
template <class T>
[[nodiscard]] core::Expected<std::vector<std::uint8_t>> Encode(const T& message) {
  const int size = message.getEncodedSize();
  std::vector<std::uint8_t> bytes(size > 0 ? static_cast<std::size_t>(size) : 0U);
  if (size <= 0 || message.encode(bytes.data(), 0, size) != size) {
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        std::string("encode ") + T::getTypeName() + ": a count field does not fit its array");
  }
  return bytes;
}

/// A message from bytes that may be anything. The generated decoders trust the counts inside the
/// message (they allocate n elements and multiply in 32 bits), so the bytes are first checked
/// against the type's layout (LcmType::Check): afterwards decoding cannot fail, over-read or
/// allocate more than the message holds. Errors: kFormat (other type, cut, too long, counts that do
/// not fit).
template <class T>
[[nodiscard]] core::Expected<T> Decode(std::span<const std::uint8_t> bytes) {
  static const LcmType& type = internal::BuiltinType(T::getTypeName(), T::getHash());
  if (auto ok = type.Check(bytes); !ok) return tl::unexpected(std::move(ok.error()));
  T message;
  const int size = static_cast<int>(bytes.size());  // Check refuses more than 2 GiB
  if (message.decode(bytes.data(), 0, size) != size) {
    return core::Fail(core::ErrorCode::kFormat,
                      std::string(T::getTypeName()) + ": does not decode");
  }
  return message;
}

}  // namespace kawara::comms
