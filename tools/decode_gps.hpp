#pragma once
#include "drivers/gnss_message.hpp"
#include "drivers/receiver_profile.hpp"
#include "tools/json_lines.hpp"

namespace kawara::tools {

/// The members of one message after "type" and "offset". SI units, angles in degrees; null: the
/// receiver left the field empty.
void WriteText(JsonLines& out, const drivers::NmeaBody& body, drivers::ReceiverProfile profile);
void WriteText(JsonLines& out, const drivers::AshtechBody& body, drivers::ReceiverProfile profile);
void WriteBinary(JsonLines& out, const drivers::GnssMessage& message);

/// "13:28:19.6"; null without a time.
void WriteTimeOfDay(JsonLines& out, std::string_view key,
                    const std::optional<core::Duration>& time);
/// "2020-03-18"
void WriteDate(JsonLines& out, std::string_view key, int year, int month, int day);

}  // namespace kawara::tools
