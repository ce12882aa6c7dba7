#include "sim/site/text_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>

namespace kawara::sim {

core::Expected<void> WriteTextFile(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".new";
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return tl::unexpected(core::ErrnoError("create " + temporary, errno));
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const core::Error error = core::ErrnoError("write " + temporary, errno);
      ::close(fd);
      ::unlink(temporary.c_str());
      return tl::unexpected(error);
    }
    done += static_cast<std::size_t>(n);
  }
  if (::close(fd) != 0 || std::rename(temporary.c_str(), path.c_str()) != 0) {
    const core::Error error = core::ErrnoError("rename to " + path, errno);
    ::unlink(temporary.c_str());
    return tl::unexpected(error);
  }
  return {};
}

std::string Fixed(double value, int decimals) {
  char buffer[64];
  const auto [end, code] =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  std::string text(buffer, code == std::errc() ? end : buffer);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

std::string JsonText(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(c));
      out += escape;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string JsonPosition(const core::Geodetic& g) {
  return "[" + Fixed(g.lon_rad * core::kDegFromRad, 10) + ", " +
         Fixed(g.lat_rad * core::kDegFromRad, 10) + ", " + Fixed(g.h_ellipsoidal_m, 4) + "]";
}

}  // namespace kawara::sim
