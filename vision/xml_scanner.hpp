#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace kawara::vision {

/// One tag of an XML text. Views and offsets into that text.
struct XmlTag {
  enum class Kind { kOpen, kClose, kEmpty };
  struct Attribute {
    std::string_view name;
    std::string_view value;  ///< still escaped
    std::size_t begin = 0;   ///< with the white space before it
    std::size_t end = 0;     ///< after the closing quote
  };
  Kind kind = Kind::kOpen;
  std::string_view name;
  std::vector<Attribute> attributes;
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Finds the tags of the small XML that XMP packets are made of: no validation beyond balance, no
/// entities beyond the five built in and character numbers, no document types. Comments, CDATA and
/// processing instructions are passed over. False: not balanced, or cut short. Bounded: at most
/// `max_tags`.
bool ScanXml(std::string_view text, std::vector<XmlTag>* tags, std::size_t max_tags = 20000);

std::string EscapeXml(std::string_view text);
std::string UnescapeXml(std::string_view text);

}  // namespace kawara::vision
