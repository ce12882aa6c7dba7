#pragma once
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace kawara::core {

/// What kind of thing the world did to us; the message says the rest (what, where, how to mend it).
enum class ErrorCode {
  kInvalidArgument,  ///< what the caller or the user asked for makes no sense
  kNotFound,         ///< no such file, device, channel, key
  kPermission,       ///< the system refuses
  kIo,               ///< a read, write or call failed
  kFormat,           ///< bytes that are not what they should be
  kTimeout,          ///< nothing came in time
  kFull,             ///< disk, ring or table is full
  kUnavailable,      ///< gone or not there yet (unplugged, disconnected): worth another try
};

struct Error {
  ErrorCode code;
  std::string message;  ///< one line, for people
};

/// Answer to everything the world can make fail (HOUSE_STYLE: errors, kind 2). Never thrown, never
/// ignored.
template <class T>
using Expected = tl::expected<T, Error>;

/// return Fail(ErrorCode::kIo, "read /dev/ttyUSB0: ...");
inline tl::unexpected<Error> Fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

/// "what: strerror(errno)" with the code that fits errno. Call it before anything else can change
/// errno.
Error ErrnoError(const std::string& what, int errno_value);

}  // namespace kawara::core
