#include "vision/xml_scanner.hpp"

#include <cstdint>

namespace kawara::vision {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kNameEnd = " \t\r\n=/><\"'";

std::size_t SkipSpace(std::string_view text, std::size_t at) {
  const std::size_t found = text.find_first_not_of(kSpace, at);
  return found == std::string_view::npos ? text.size() : found;
}

// Reads one tag at `at` (which holds '<'). False: malformed.
bool ReadTag(std::string_view text, std::size_t at, XmlTag* tag) {
  tag->begin = at++;
  if (at < text.size() && text[at] == '/') {
    tag->kind = XmlTag::Kind::kClose;
    ++at;
  }
  const std::size_t name_end = text.find_first_of(kNameEnd, at);
  if (name_end == std::string_view::npos || name_end == at) return false;
  tag->name = text.substr(at, name_end - at);
  at = name_end;
  while (true) {
    const std::size_t before_space = at;
    at = SkipSpace(text, at);
    if (at >= text.size()) return false;
    if (text[at] == '>') break;
    if (text[at] == '/') {
      if (at + 1 >= text.size() || text[at + 1] != '>' || tag->kind == XmlTag::Kind::kClose)
        return false;
      tag->kind = XmlTag::Kind::kEmpty;
      ++at;
      break;
    }
    XmlTag::Attribute attribute;
    const std::size_t end = text.find_first_of(kNameEnd, at);
    if (end == std::string_view::npos || end == at) return false;
    attribute.name = text.substr(at, end - at);
    at = SkipSpace(text, end);
    if (at >= text.size() || text[at] != '=') return false;
    at = SkipSpace(text, at + 1);
    if (at >= text.size() || (text[at] != '"' && text[at] != '\'')) return false;
    const std::size_t quote = text.find(text[at], at + 1);
    if (quote == std::string_view::npos) return false;
    attribute.value = text.substr(at + 1, quote - at - 1);
    attribute.begin = before_space;
    attribute.end = at = quote + 1;
    tag->attributes.push_back(attribute);
  }
  tag->end = at + 1;
  return true;
}

void AppendUtf8(std::uint32_t code, std::string* out) {
  const auto put = [&](std::uint32_t byte) { out->push_back(static_cast<char>(byte)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | code >> 6);
    put(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3F));
    put(0x80 | (code & 0x3F));
  } else {
    put(0xF0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3F));
    put(0x80 | (code >> 6 & 0x3F));
    put(0x80 | (code & 0x3F));
  }
}

// "#65" or "#x41" to UTF-8. False: not a character.
bool AppendNumbered(std::string_view entity, std::string* out) {
  const bool hex = entity.size() > 2 && entity[1] == 'x';
  std::uint32_t code = 0;
  for (char c : entity.substr(hex ? 2 : 1)) {
    std::uint32_t digit = 99;
    if (c >= '0' && c <= '9') digit = static_cast<std::uint32_t>(c - '0');
    if (hex && c >= 'a' && c <= 'f') digit = static_cast<std::uint32_t>(c - 'a') + 10;
    if (hex && c >= 'A' && c <= 'F') digit = static_cast<std::uint32_t>(c - 'A') + 10;
    if (digit > 15) return false;
    code = code * (hex ? 16 : 10) + digit;
    if (code > 0x10FFFF) return false;
  }
  if (code == 0) return false;
  AppendUtf8(code, out);
  return true;
}

}  // namespace

bool ScanXml(std::string_view text, std::vector<XmlTag>* tags, std::size_t max_tags) {
  tags->clear();
  std::vector<std::string_view> open;
  std::size_t at = 0;
  const auto skip = [&](std::string_view start, std::string_view end) {
    if (text.substr(at, start.size()) != start) return false;
    const std::size_t found = text.find(end, at + start.size());
    at = found == std::string_view::npos ? text.size() + 1 : found + end.size();
    return true;
  };
  while ((at = text.find('<', at)) != std::string_view::npos) {
    if (skip("<!--", "-->") || skip("<![CDATA[", "]]>") || skip("<?", "?>")) {
      if (at > text.size()) return false;
      continue;
    }
    XmlTag tag;
    if (tags->size() >= max_tags || !ReadTag(text, at, &tag)) return false;
    if (tag.kind == XmlTag::Kind::kOpen) {
      open.push_back(tag.name);
    } else if (tag.kind == XmlTag::Kind::kClose) {
      if (open.empty() || open.back() != tag.name) return false;
      open.pop_back();
    }
    at = tag.end;
    tags->push_back(std::move(tag));
  }
  return open.empty() && !tags->empty();
}

std::string EscapeXml(std::string_view text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        // XML 1.0 has no way to write the other control characters.
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\t' || c == '\n') out += c;
    }
  }
  return out;
}

std::string UnescapeXml(std::string_view text) {
  constexpr std::pair<std::string_view, char> kNamed[] = {
      {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
  std::string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] != '&') {
      out += text[at];
      continue;
    }
    const std::size_t end = text.find(';', at);
    bool known = false;
    if (end != std::string_view::npos && end - at <= 10) {
      const std::string_view entity = text.substr(at + 1, end - at - 1);
      for (const auto& [name, character] : kNamed) {
        if (entity == name) {
          out += character;
          known = true;
        }
      }
      if (!known && entity.starts_with('#')) known = AppendNumbered(entity, &out);
    }
    if (known) {
      at = end;
    } else {
      out += '&';
    }
  }
  return out;
}

}  // namespace kawara::vision
