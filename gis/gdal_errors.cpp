#include "gis/gdal_errors.hpp"

#include <cpl_error.h>

#include <array>
#include <regex>
#include <string_view>

namespace kawara::gis {
namespace {

void CPL_STDCALL OnGdalError(CPLErr level, CPLErrorNum /*number*/, const char* text) {
  auto* catcher = static_cast<GdalErrorCatcher*>(CPLGetErrorHandlerUserData());
  if (level >= CE_Warning) catcher->Take(level >= CE_Failure, text);
}

struct Rule {
  std::string_view says;  ///< part of what the library says
  core::ErrorCode code;
  std::string_view cure;
};

/// First match wins.
constexpr std::array<Rule, 23> kRules{{
    {"database is locked", core::ErrorCode::kUnavailable, "another program is writing to it"},
    {"database table is locked", core::ErrorCode::kUnavailable, "another program is writing to it"},
    {"disk is full", core::ErrorCode::kFull, "free some space"},
    {"No space left", core::ErrorCode::kFull, "free some space"},
    {"disk I/O error", core::ErrorCode::kIo, "is the disk full or failing?"},
    {"attempt to write a readonly", core::ErrorCode::kPermission,
     "the file or its folder is read-only"},
    {"unable to open database file", core::ErrorCode::kPermission,
     "the folder must exist and be writable"},
    {"not recognized as a supported file format", core::ErrorCode::kFormat,
     "it is not a GeoPackage: name another file"},
    {"file is not a database", core::ErrorCode::kFormat,
     "it is not a GeoPackage: name another file"},
    {"malformed", core::ErrorCode::kFormat, "the file is damaged: sqlite3 FILE .recover"},
    {"password", core::ErrorCode::kPermission,
     "check user= and password=, or the server's pg_hba.conf"},
    {"pg_hba.conf", core::ErrorCode::kPermission, "let this host in, in the server's pg_hba.conf"},
    {"permission denied", core::ErrorCode::kPermission,
     "the database user needs the right to create tables here"},
    {"Peer authentication failed", core::ErrorCode::kPermission, "name a user= that may log in"},
    {"role \"", core::ErrorCode::kNotFound, "createuser it, or name another user="},
    {"\" does not exist", core::ErrorCode::kNotFound, "createdb it, or name another one"},
    {"starting up", core::ErrorCode::kUnavailable, "the server is not ready yet"},
    {"shutting down", core::ErrorCode::kUnavailable, "the server is going down"},
    {"Connection refused", core::ErrorCode::kUnavailable, "is the server running?"},
    {"could not connect", core::ErrorCode::kUnavailable, "is the server running?"},
    {"connection to server", core::ErrorCode::kUnavailable, "is the server running?"},
    {"server closed the connection", core::ErrorCode::kUnavailable, "is the server running?"},
    {"terminating connection", core::ErrorCode::kUnavailable, "the server ended the connection"},
}};

}  // namespace

GdalErrorCatcher::GdalErrorCatcher() { CPLPushErrorHandlerEx(OnGdalError, this); }
GdalErrorCatcher::~GdalErrorCatcher() { CPLPopErrorHandler(); }

void GdalErrorCatcher::Take(bool failure, const char* text) {
  if (message_.empty() || (failure && !failed_)) {
    message_ = text;
    for (char& c : message_)
      if (c == '\n' || c == '\r' || c == '\t') c = ' ';
    while (!message_.empty() && message_.back() == ' ') message_.pop_back();
  }
  failed_ = failed_ || failure;
}

core::Error ErrorFromGdal(const std::string& target, const std::string& doing,
                          const std::string& gdal_message) {
  const std::string line =
      target + ": " + doing + ": " + (gdal_message.empty() ? "failed" : gdal_message);
  for (const Rule& rule : kRules) {
    if (gdal_message.find(rule.says) != std::string::npos)
      return {rule.code, line + " (" + std::string(rule.cure) + ")"};
  }
  return {core::ErrorCode::kIo, line};
}

std::string WithoutPassword(const std::string& target) {
  static const std::regex kPassword("password *= *('[^']*'|[^ ]*)", std::regex::icase);
  return std::regex_replace(target, kPassword, "password=***");
}

}  // namespace kawara::gis
