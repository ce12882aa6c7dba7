#include "comms/log_crc.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <kawara/log_crc_t.hpp>

#include "comms/codec.hpp"
#include "comms/crc32c.hpp"
#include "core/check.hpp"

namespace kawara::comms {
namespace {

std::uint64_t GetBigEndian(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t b : bytes) value = value << 8 | b;
  return value;
}

void PutBigEndian(std::uint8_t* out, std::uint64_t value, unsigned bytes) {
  for (unsigned i = 0; i < bytes; ++i)
    out[i] = static_cast<std::uint8_t>(value >> (8 * (bytes - 1 - i)));
}

}  // namespace

LogRecordHeader ReadRecordHeader(std::span<const std::uint8_t, kLogHeaderBytes> bytes) {
  return {static_cast<std::uint32_t>(GetBigEndian(bytes.first(4))),
          static_cast<std::int64_t>(GetBigEndian(bytes.subspan(4, 8))),
          static_cast<std::int64_t>(GetBigEndian(bytes.subspan(12, 8))),
          static_cast<std::int32_t>(GetBigEndian(bytes.subspan(20, 4))),
          static_cast<std::int32_t>(GetBigEndian(bytes.subspan(24, 4)))};
}

void AppendRecord(std::vector<std::uint8_t>& out, std::int64_t number, std::int64_t time_utc_us,
                  std::string_view channel, std::span<const std::uint8_t> data) {
  std::array<std::uint8_t, kLogHeaderBytes> header{};
  PutBigEndian(header.data(), kLogSync, 4);
  PutBigEndian(header.data() + 4, static_cast<std::uint64_t>(number), 8);
  PutBigEndian(header.data() + 12, static_cast<std::uint64_t>(time_utc_us), 8);
  PutBigEndian(header.data() + 20, channel.size(), 4);
  PutBigEndian(header.data() + 24, data.size(), 4);
  out.insert(out.end(), header.begin(), header.end());
  out.insert(out.end(), channel.begin(), channel.end());
  out.insert(out.end(), data.begin(), data.end());
}

std::vector<std::uint8_t> MakeLogCrcRecord(std::int64_t number, std::int64_t time_utc_us,
                                           std::span<const LogCrcEntry> entries) {
  log_crc_t message;
  for (const LogCrcEntry& entry : entries) {
    message.number.push_back(entry.number);
    message.crc32c.push_back(static_cast<std::int32_t>(entry.crc32c));
  }
  message.number.push_back(number);
  message.crc32c.push_back(0);
  message.n = static_cast<std::int32_t>(message.number.size());
  const auto data = Encode(message);
  CORE_CHECK(data.has_value());
  std::vector<std::uint8_t> record;
  AppendRecord(record, number, time_utc_us, kLogCrcChannel, *data);
  CORE_CHECK(record.size() == LogCrcRecordBytes(entries.size()));
  const std::size_t own_crc = record.size() - 4;
  PutBigEndian(record.data() + own_crc, Crc32c(std::span(record).first(own_crc)), 4);
  return record;
}

bool IsLogCrcMessage(std::span<const std::uint8_t> data) {
  return data.size() >= 8 &&
         static_cast<std::int64_t>(GetBigEndian(data.first(8))) == log_crc_t::getHash();
}

std::optional<std::vector<LogCrcEntry>> ReadLogCrcRecord(std::span<const std::uint8_t> record) {
  const std::size_t data_begin = kLogHeaderBytes + kLogCrcChannel.size();
  if (record.size() < data_begin + 4) return std::nullopt;
  const auto channel = record.subspan(kLogHeaderBytes, kLogCrcChannel.size());
  if (std::memcmp(channel.data(), kLogCrcChannel.data(), channel.size()) != 0) return std::nullopt;
  const auto own_crc = static_cast<std::uint32_t>(GetBigEndian(record.last(4)));
  if (Crc32c(record.first(record.size() - 4)) != own_crc) return std::nullopt;
  const auto message = Decode<log_crc_t>(record.subspan(data_begin));
  if (!message || message->n < 1) return std::nullopt;
  std::vector<LogCrcEntry> entries(static_cast<std::size_t>(message->n) - 1);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i] = {message->number[i], static_cast<std::uint32_t>(message->crc32c[i])};
  }
  return entries;
}

}  // namespace kawara::comms
