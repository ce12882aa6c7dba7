#include "vision/xmp_packet.hpp"

#include <map>

#include "vision/xml_scanner.hpp"

namespace kawara::vision {
namespace {

constexpr std::string_view kRdfUri = "http://www.w3.org/1999/02/22-rdf-syntax-ns#";
constexpr XmpNamespace kOurs[] = {kGPanoNamespace, kKawaraNamespace};

using Prefixes =
    std::map<std::string_view, std::string_view>;  // prefix -> URI, over the whole packet

Prefixes FindPrefixes(const std::vector<XmlTag>& tags) {
  Prefixes prefixes;
  for (const XmlTag& tag : tags) {
    for (const auto& attribute : tag.attributes) {
      if (attribute.name.starts_with("xmlns:"))
        prefixes[attribute.name.substr(6)] = attribute.value;
    }
  }
  return prefixes;
}

struct QualifiedName {
  std::string_view uri;
  std::string_view local;
};

QualifiedName Resolve(const Prefixes& prefixes, std::string_view name) {
  const std::size_t colon = name.find(':');
  if (colon == std::string_view::npos) return {{}, name};
  const auto found = prefixes.find(name.substr(0, colon));
  return {found == prefixes.end() ? std::string_view{} : found->second, name.substr(colon + 1)};
}

bool IsOurs(const Prefixes& prefixes, std::string_view name) {
  const std::string_view uri = Resolve(prefixes, name).uri;
  for (const XmpNamespace& space : kOurs) {
    if (uri == space.uri) return true;
  }
  return false;
}

std::string Description(std::span<const XmpProperty> properties, std::string_view rdf_prefix,
                        std::string_view about) {
  const std::string rdf(rdf_prefix);
  std::string out = "<" + rdf + ":Description " + rdf + ":about=\"" + std::string(about) + "\"";
  for (const XmpNamespace& space : kOurs) {
    out += "\n    xmlns:" + std::string(space.prefix) + "=\"" + std::string(space.uri) + "\"";
  }
  for (const XmpProperty& property : properties) {
    out += "\n   " + std::string(property.space.prefix) + ":" + std::string(property.name) + "=\"" +
           EscapeXml(property.value) + "\"";
  }
  return out + "/>\n";
}

std::string FreshPacket(std::span<const XmpProperty> properties) {
  return "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
         "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\" x:xmptk=\"Kawaraban\">\n"
         " <rdf:RDF xmlns:rdf=\"" +
         std::string(kRdfUri) + "\">\n  " + Description(properties, "rdf", "") +
         " </rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>";
}

// The old packet without our namespaces and with the new description; empty if it makes no sense.
std::optional<std::string> Merge(std::span<const XmpProperty> properties, std::string_view old) {
  std::vector<XmlTag> tags;
  if (!ScanXml(old, &tags)) return {};
  const Prefixes prefixes = FindPrefixes(tags);
  const auto is_rdf = [&](const XmlTag& tag, std::string_view local) {
    const QualifiedName name = Resolve(prefixes, tag.name);
    return name.uri == kRdfUri && name.local == local;
  };
  std::string out;
  std::string_view about;
  std::size_t copied = 0;  // old text up to here is dealt with
  const auto copy_until = [&](std::size_t end) {
    out += old.substr(copied, end - copied);
    copied = end;
  };
  int inside_ours = 0;  // depth of elements being dropped
  bool written = false;
  for (const XmlTag& tag : tags) {
    if (inside_ours > 0 || (tag.kind != XmlTag::Kind::kClose && IsOurs(prefixes, tag.name))) {
      if (inside_ours == 0) copy_until(tag.begin);
      inside_ours += tag.kind == XmlTag::Kind::kOpen    ? 1
                     : tag.kind == XmlTag::Kind::kClose ? -1
                                                        : 0;
      copied = tag.end;
      continue;
    }
    for (const auto& attribute : tag.attributes) {
      const QualifiedName name = Resolve(prefixes, attribute.name);
      if (about.empty() && name.uri == kRdfUri && name.local == "about") about = attribute.value;
      if (!IsOurs(prefixes, attribute.name)) continue;
      copy_until(attribute.begin);
      copied = attribute.end;
    }
    if (!written && tag.kind == XmlTag::Kind::kClose && is_rdf(tag, "RDF")) {
      copy_until(tag.begin);
      out += " " + Description(properties, tag.name.substr(0, tag.name.find(':')), about);
      written = true;
    }
  }
  if (!written) return {};
  copy_until(old.size());
  return out;
}

}  // namespace

std::string WriteXmpPacket(std::span<const XmpProperty> properties,
                           std::optional<std::string_view> old_packet) {
  if (old_packet) {
    if (auto merged = Merge(properties, *old_packet)) return *merged;
  }
  return FreshPacket(properties);
}

std::vector<std::pair<std::string, std::string>> ReadXmpProperties(std::string_view packet,
                                                                   const XmpNamespace& space) {
  std::vector<std::pair<std::string, std::string>> found;
  std::vector<XmlTag> tags;
  if (!ScanXml(packet, &tags)) return found;
  const Prefixes prefixes = FindPrefixes(tags);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const XmlTag& tag = tags[i];
    for (const auto& attribute : tag.attributes) {
      const QualifiedName name = Resolve(prefixes, attribute.name);
      if (name.uri == space.uri) found.emplace_back(name.local, UnescapeXml(attribute.value));
    }
    const QualifiedName name = Resolve(prefixes, tag.name);
    const bool simple = tag.kind == XmlTag::Kind::kOpen && i + 1 < tags.size() &&
                        tags[i + 1].kind == XmlTag::Kind::kClose;
    if (simple && name.uri == space.uri) {
      found.emplace_back(name.local,
                         UnescapeXml(packet.substr(tag.end, tags[i + 1].begin - tag.end)));
    }
  }
  return found;
}

}  // namespace kawara::vision
