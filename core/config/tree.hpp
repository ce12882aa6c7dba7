#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/config/problems.hpp"

namespace kawara::core::config {

/// A parsed YAML document as plain data, with the place of every node: what the typed reader works
/// on.
struct Node {
  enum class Kind { kNull, kScalar, kSequence, kMap };
  Kind kind = Kind::kNull;
  std::string text;     ///< kScalar: its value
  bool quoted = false;  ///< kScalar: was written in quotes, so it is text, never a number
  Place place;
  std::vector<Node> keys;   ///< kMap: scalars, in file order, each key once
  std::vector<Node> items;  ///< kMap: value of keys[i]; kSequence: the elements

  const Node* Find(std::string_view key) const;
  Node* Find(std::string_view key);
  /// As shown in error messages: the text, cut and on one line; "[...]", "{...}", "(nothing)".
  std::string Shown() const;
};

/// Parses one YAML document. Mistakes of syntax, duplicate keys and everything beyond plain data
/// (anchors, aliases, several documents) go to `problems` with their places; what could be read
/// comes back all the same. Never throws on bad input. Limits: 1 MiB, 64 levels.
Node ParseYaml(std::string_view text, const std::string& source, Problems& problems);

/// Applies "dotted.key=value" or "list[2].key=value" (from --set on a command line) to the tree. A
/// value that starts with [ { " or ' is YAML, any other is taken as it stands. Missing sections are
/// made; whether the key exists at all is for the typed reader to say.
void ApplyOverride(Node& root, const std::string& assignment, Problems& problems);

}  // namespace kawara::core::config
