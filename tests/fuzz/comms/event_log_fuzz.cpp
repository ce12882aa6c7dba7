#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "comms/event_log_reader.hpp"

using namespace kawara::comms;

// Any bytes as a log file: never a crash, every byte accounted for, events in ascending file order
// without overlap.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const int fd = ::memfd_create("fuzz", MFD_CLOEXEC);
  static const std::string path = "/proc/self/fd/" + std::to_string(fd);
  if (fd < 0 || ::ftruncate(fd, 0) != 0) std::abort();
  if (::pwrite(fd, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  for (const bool deliver_log_crc : {true, false}) {
    auto reader = EventLogReader::Open({path}, {.deliver_log_crc = deliver_log_crc});
    if (!reader) return 0;  // no event in it
    std::uint64_t good_bytes = 0;
    while (const auto event = reader->Next()) {
      if (event->channel.empty() || event->channel.size() > kLogMaxChannelBytes) std::abort();
      good_bytes += kLogHeaderBytes + event->channel.size() + event->data.size();
    }
    const LogReaderStats& stats = reader->stats();
    if (stats.bytes != size || good_bytes + stats.damaged_bytes > size) std::abort();
    if (deliver_log_crc && good_bytes + stats.damaged_bytes != size) std::abort();
  }
  return 0;
}
