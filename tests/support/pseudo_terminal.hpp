#pragma once
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/check.hpp"

namespace kawara::testing {

/// The instrument's end of a serial line. Unplug() closes it: the other end hangs up.
class PseudoTerminal {
 public:
  PseudoTerminal() : master_(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    CORE_CHECK(master_ >= 0 && grantpt(master_) == 0 && unlockpt(master_) == 0);
    std::array<char, 64> name{};
    CORE_CHECK(ptsname_r(master_, name.data(), name.size()) == 0);
    path_ = name.data();
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  ~PseudoTerminal() { Unplug(); }

  const std::string& path() const { return path_; }
  int fd() const { return master_; }
  void Unplug() {
    if (master_ >= 0) close(master_);
    master_ = -1;
  }
  void Send(std::span<const std::uint8_t> bytes) {
    const ssize_t n = write(master_, bytes.data(), bytes.size());
    CORE_CHECK(n == static_cast<ssize_t>(bytes.size()));
  }
  void Send(std::string_view text) {
    Send(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }
  /// What was written to the instrument so far.
  std::string Receive() {
    std::array<char, 4096> buffer{};
    const ssize_t n = read(master_, buffer.data(), buffer.size());
    return n > 0 ? std::string(buffer.data(), static_cast<std::size_t>(n)) : std::string();
  }

 private:
  int master_;
  std::string path_;
};

/// True as soon as `fd` has something to read (data or hang-up); false after two seconds.
inline bool WaitReadable(int fd) {
  pollfd p{fd, POLLIN, 0};
  return poll(&p, 1, 2000) == 1;
}

}  // namespace kawara::testing
