#pragma once
#include <sys/stat.h>

#include <optional>
#include <string>

namespace kawara::gis {

/// Which file a name stands for: another one if somebody has moved or deleted the old one.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  bool operator==(const FileIdentity&) const = default;
};

/// Nothing: there is none.
inline std::optional<FileIdentity> IdentityOf(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileIdentity{status.st_dev, status.st_ino};
}

}  // namespace kawara::gis
