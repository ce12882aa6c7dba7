#include "vision/xmp_packet.hpp"

#include <algorithm>
#include <initializer_list>
#include <iterator>

#include "vision/xml_scanner.hpp"

namespace kawara::vision {
namespace {

constexpr std::string_view kRdfUri = "http://www.w3.org/1999/02/22-rdf-syntax-ns#";
constexpr XmpNamespace kOurs[] = {kGPanoNamespace, kKawaraNamespace};

struct QualifiedName {
  std::string_view uri;
  std::string_view local;
};

/// Which prefix means which namespace, element by element.
class Scopes {
 public:
  /// Call for every tag in order, before resolving its names; Leave after them.
  void Enter(const XmlTag& tag) {
    if (tag.kind == XmlTag::Kind::kClose) return;
    marks_.push_back(declared_.size());
    for (const auto& attribute : tag.attributes) {
      if (attribute.name.starts_with("xmlns:")) {
        declared_.push_back({attribute.name.substr(6), attribute.value});
      }
    }
  }
  void Leave(const XmlTag& tag) {
    if (tag.kind == XmlTag::Kind::kOpen) return;
    declared_.resize(marks_.back());
    marks_.pop_back();
  }
  QualifiedName Resolve(std::string_view name) const {
    const std::size_t colon = name.find(':');
    if (colon == std::string_view::npos) return {{}, name};
    for (auto it = declared_.rbegin(); it != declared_.rend(); ++it) {
      if (it->prefix == name.substr(0, colon)) return {it->uri, name.substr(colon + 1)};
    }
    return {{}, name.substr(colon + 1)};
  }
  bool IsOurs(std::string_view name) const {
    const std::string_view uri = Resolve(name).uri;
    return std::any_of(std::begin(kOurs), std::end(kOurs),
                       [&](const XmpNamespace& space) { return uri == space.uri; });
  }

 private:
  std::vector<XmpNamespace> declared_;
  std::vector<std::size_t> marks_;
};

void Append(std::string* out, std::initializer_list<std::string_view> parts) {
  for (std::string_view part : parts) out->append(part);
}

std::string Description(std::span<const XmpProperty> properties, std::string_view rdf,
                        std::string_view about) {
  std::string out;
  Append(&out, {"<", rdf, ":Description ", rdf, ":about=\"", about, "\""});
  for (const XmpNamespace& space : kOurs) {
    Append(&out, {"\n    xmlns:", space.prefix, "=\"", space.uri, "\""});
  }
  for (const XmpProperty& property : properties) {
    Append(&out, {"\n   ", property.space.prefix, ":", property.name, "=\"",
                  EscapeXml(property.value), "\""});
  }
  return out.append("/>\n");
}

std::string FreshPacket(std::span<const XmpProperty> properties) {
  std::string out;
  Append(&out, {"<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
                "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\" x:xmptk=\"Kawaraban\">\n"
                " <rdf:RDF xmlns:rdf=\"",
                kRdfUri, "\">\n  ", Description(properties, "rdf", ""),
                " </rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>"});
  return out;
}

// The old packet without our namespaces and with the new description; empty if it makes no sense.
std::optional<std::string> Merge(std::span<const XmpProperty> properties, std::string_view old) {
  std::vector<XmlTag> tags;
  if (!ScanXml(old, &tags)) return {};
  Scopes scopes;
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
    scopes.Enter(tag);
    if (inside_ours > 0 || (tag.kind != XmlTag::Kind::kClose && scopes.IsOurs(tag.name))) {
      if (inside_ours == 0) copy_until(tag.begin);
      if (tag.kind == XmlTag::Kind::kOpen) ++inside_ours;
      if (tag.kind == XmlTag::Kind::kClose) --inside_ours;
      copied = tag.end;
    } else {
      for (const auto& attribute : tag.attributes) {
        const QualifiedName name = scopes.Resolve(attribute.name);
        if (about.empty() && name.uri == kRdfUri && name.local == "about") about = attribute.value;
        if (!scopes.IsOurs(attribute.name)) continue;
        copy_until(attribute.begin);
        copied = attribute.end;
      }
      const QualifiedName name = scopes.Resolve(tag.name);
      if (!written && tag.kind == XmlTag::Kind::kClose && name.uri == kRdfUri &&
          name.local == "RDF") {
        copy_until(tag.begin);
        Append(&out, {" ", Description(properties, tag.name.substr(0, tag.name.find(':')), about)});
        written = true;
      }
    }
    scopes.Leave(tag);
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
  Scopes scopes;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const XmlTag& tag = tags[i];
    scopes.Enter(tag);
    for (const auto& attribute : tag.attributes) {
      const QualifiedName name = scopes.Resolve(attribute.name);
      if (name.uri == space.uri) found.emplace_back(name.local, UnescapeXml(attribute.value));
    }
    const QualifiedName name = scopes.Resolve(tag.name);
    const bool simple = tag.kind == XmlTag::Kind::kOpen && i + 1 < tags.size() &&
                        tags[i + 1].kind == XmlTag::Kind::kClose;
    if (simple && name.uri == space.uri) {
      found.emplace_back(name.local,
                         UnescapeXml(packet.substr(tag.end, tags[i + 1].begin - tag.end)));
    }
    scopes.Leave(tag);
  }
  return found;
}

}  // namespace kawara::vision
