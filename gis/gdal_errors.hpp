#pragma once
#include <string>

#include "core/expected.hpp"

namespace kawara::gis {

/// While it lives, GDAL on this thread prints nothing; its complaints are kept instead. Nestable.
class GdalErrorCatcher {
 public:
  GdalErrorCatcher();
  ~GdalErrorCatcher();
  GdalErrorCatcher(const GdalErrorCatcher&) = delete;
  GdalErrorCatcher& operator=(const GdalErrorCatcher&) = delete;

  bool failed() const { return failed_; }
  /// The first failure (else the first warning) in one line; empty: GDAL had nothing to say.
  const std::string& message() const { return message_; }
  /// Called by GDAL.
  void Take(bool failure, const char* text);

 private:
  std::string message_;
  bool failed_ = false;
};

/// Turns what SQLite, libpq or the file system said through GDAL into the code a caller can act on,
/// and adds the way to mend it: "obs.gpkg: commit: database is locked (another program is writing
/// to it; trying again)".
core::Error ErrorFromGdal(const std::string& target, const std::string& doing,
                          const std::string& gdal_message);

/// "PG:host=hq password=..." without the password, for messages and logs.
std::string WithoutPassword(const std::string& target);

}  // namespace kawara::gis
