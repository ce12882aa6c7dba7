#include "drivers/gnss_message.hpp"

namespace kawara::drivers {
namespace {

GnssTypeName UbxName(const UbxMessage& ubx) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  GnssTypeName name("UBX.");
  const auto append = [&](std::uint8_t byte) {
    name.Append(kHex.substr(byte >> 4, 1)).Append(kHex.substr(byte & 15U, 1));
  };
  append(ubx.message_class);
  name.Append(".");
  append(ubx.id);
  return name;
}

}  // namespace

GnssTypeName TypeName(const GnssMessage& message) {
  if (const auto* rtcm3 = message.As<Rtcm3Message>())
    return GnssTypeName("RTCM3.").Append(rtcm3->type);
  if (const auto* rtcm2 = message.As<const Rtcm2Message*>())
    return GnssTypeName("RTCM2.").Append((*rtcm2)->type);
  if (message.As<AshtechPbn>() != nullptr) return "PBN";
  if (const auto* record = message.As<AshtechRecord>()) return record->type.view();
  if (const auto* ubx = message.As<UbxMessage>()) return UbxName(*ubx);
  return message.sentence.address;
}

bool IsInvalid(const GnssMessage& message) {
  if (const auto* nmea = message.As<NmeaBody>()) return std::holds_alternative<NmeaInvalid>(*nmea);
  if (const auto* ashtech = message.As<AshtechBody>())
    return std::holds_alternative<AshtechInvalid>(*ashtech);
  if (const auto* pbn = message.As<AshtechPbn>()) return !pbn->plausible;
  if (const auto* rtcm3 = message.As<Rtcm3Message>()) return rtcm3->malformed;
  if (const auto* rtcm2 = message.As<const Rtcm2Message*>()) return (*rtcm2)->malformed;
  return false;
}

}  // namespace kawara::drivers
