#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "tools/navigate/csv_reader.hpp"

/// Any bytes as a recording, plain or gzip: rows or one clear error; every number of a row is
/// finite where it must be.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using kawara::navigate::CsvColumn;
  static const int file = memfd_create("recording", 0);
  if (file < 0 || ftruncate(file, 0) != 0) std::abort();
  if (pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(file);

  constexpr std::array<CsvColumn, 4> kColumns = {{{"t", CsvColumn::Kind::kTime},
                                                  {"wx", CsvColumn::Kind::kNumber},
                                                  {"sd", CsvColumn::Kind::kOptionalNumber},
                                                  {"t_rx", CsvColumn::Kind::kOptionalTime}}};
  auto reader = kawara::navigate::CsvReader::Open(path, kColumns);
  if (!reader) {
    if (reader.error().message.empty()) std::abort();
    return 0;
  }
  for (;;) {
    const auto row = reader->Next();
    if (!row) {
      if (row.error().message.empty()) std::abort();
      break;
    }
    if (!*row) break;
    if (!((*row)->number[1] - (*row)->number[1] == 0.0) || !(*row)->time[0]) std::abort();
  }
  (void)reader->report().Lines();
  return 0;
}
