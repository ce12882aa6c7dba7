#include "gis/kiwi/export_text.hpp"

#include <array>
#include <cstdio>

namespace kawara::gis {

std::string JsonString(std::string_view text) {
  std::string json = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      json += '\\';
      json += c;
    } else if (static_cast<unsigned char>(c) < 0x20U) {
      std::array<char, 8> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\u%04x",
                    static_cast<unsigned>(static_cast<unsigned char>(c)));
      json += escaped.data();
    } else {
      json += c;
    }
  }
  return json + "\"";
}

std::string JsonMember(const Attribute& attribute) {
  const bool number = !attribute.unit.empty();
  const std::string unit = number && attribute.unit != "1" ? "_" + attribute.unit : "";
  return JsonString(attribute.key + unit) + ":" +
         (number ? attribute.value : JsonString(attribute.value));
}

std::string JsonMembers(const std::vector<Attribute>& attributes) {
  std::vector<Attribute> merged;
  for (const Attribute& attribute : attributes) {
    if (!merged.empty() && merged.back().key == attribute.key) {
      merged.back().value += "," + attribute.value;
    } else {
      merged.push_back(attribute);
    }
  }
  std::string json;
  for (const Attribute& attribute : merged)
    json.append(json.empty() ? "" : ",").append(JsonMember(attribute));
  return json;
}

}  // namespace kawara::gis
