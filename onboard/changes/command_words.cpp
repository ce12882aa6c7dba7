#include "onboard/changes/command_words.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "core/iso8601.hpp"
#include "onboard/mapper/model_store.hpp"

namespace kawara::changes {

core::Expected<std::vector<double>> ParseNumbers(const std::string& word) {
  std::vector<double> numbers;
  const char* at = word.data();
  const char* const end = at + word.size();
  for (;;) {
    double value = 0.0;
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc() || !std::isfinite(value))
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "'" + word + "': expected numbers with commas between");
    numbers.push_back(value);
    if (read.ptr == end) return numbers;
    if (*read.ptr != ',')
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "'" + word + "': expected numbers with commas between");
    at = read.ptr + 1;
  }
}

core::Expected<core::Geodetic> ParseOrigin(const std::string& word) {
  std::error_code error;
  if (std::filesystem::is_directory(word, error)) {
    const auto origin = mapper::ModelStore::OriginOf(word);
    if (origin) return *origin;
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      word + ": holds no model of kawara-mapper that says where it lies");
  }
  const auto numbers = ParseNumbers(word);
  if (!numbers || numbers->size() != 3 || !(std::abs((*numbers)[0]) <= 90.0) ||
      !(std::abs((*numbers)[1]) <= 360.0))
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "'" + word +
                          "': expected the folder of a model, or LATITUDE,LONGITUDE,HEIGHT in "
                          "degrees and metres above the "
                          "ellipsoid, as 35.3606,139.5310,52.0");
  return core::Geodetic{(*numbers)[0] * core::kRadFromDeg, (*numbers)[1] * core::kRadFromDeg,
                        (*numbers)[2]};
}

core::Expected<core::UtcTime> ParseTime(const std::string& word) {
  constexpr std::size_t kDate = 10;
  return core::ParseIso8601(word.size() == kDate ? word + "T00:00:00Z" : word);
}

core::Expected<core::UtcTime> TimeOr(const std::string& word, const std::string& file) {
  if (!word.empty()) return ParseTime(word);
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0)
    return core::Fail(core::ErrorCode::kNotFound, file + ": there is no such file");
  return core::UtcTime::FromNs(std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 +
                               status.st_mtim.tv_nsec);
}

int Fail(const std::string& message, int status) {
  std::fprintf(stderr, "%s: %s\n", program_invocation_short_name, message.c_str());
  return status;
}

int Fail(const core::Error& error) {
  const bool theirs =
      error.code == core::ErrorCode::kInvalidArgument || error.code == core::ErrorCode::kNotFound;
  return Fail(error.message, theirs ? 2 : 1);
}

}  // namespace kawara::changes
