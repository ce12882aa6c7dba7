#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kawara::vision {

/// A namespace this program writes: everything of it in a packet is ours to replace.
struct XmpNamespace {
  std::string_view prefix;
  std::string_view uri;
};

constexpr XmpNamespace kGPanoNamespace{"GPano", "http://ns.google.com/photos/1.0/panorama/"};
/// Place, time and trust of a phase-1 picture with nothing lost; documented in panorama_xmp.cpp.
constexpr XmpNamespace kKawaraNamespace{"kawara", "urn:kawaraban:xmp:phase1:1#"};

struct XmpProperty {
  XmpNamespace space;
  std::string_view name;
  std::string value;  ///< plain text; escaped when written
};

/// An XMP packet (RDF/XML) that holds `properties`. With `old_packet` its other namespaces are kept
/// as they are and every property of the namespaces above is dropped first; a packet that is not
/// balanced XML with one rdf:RDF in it is replaced. Source: Adobe XMP Specification Part 1 (ISO
/// 16684-1) 7, Part 3 1.1.3.
std::string WriteXmpPacket(std::span<const XmpProperty> properties,
                           std::optional<std::string_view> old_packet);

/// All simple properties of one namespace, attribute or element form, in document order.
/// Empty for damaged packets.
std::vector<std::pair<std::string, std::string>> ReadXmpProperties(std::string_view packet,
                                                                   const XmpNamespace& space);

}  // namespace kawara::vision
