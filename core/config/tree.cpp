#include "core/config/tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <charconv>
#include <sstream>

namespace kawara::core::config {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxDepth = 64;

/// Builds the tree from yaml-cpp's events. The node classes of yaml-cpp are not used because they
/// hide duplicate keys and lose the place of keys.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& source, Problems& problems)
      : source_(source), problems_(problems) {}

  Node root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override {
    Put(Make(mark, Node::Kind::kNull));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    Node node = Make(mark, Node::Kind::kNull);
    problems_.Add(node.place, "alias: expected the value itself (* and & are not supported here)");
    Put(std::move(node));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                const std::string& value) override {
    Node node = Make(mark, Node::Kind::kScalar);
    node.text = value;
    node.quoted = tag == "!";  // yaml-cpp's way to say so
    if (!tag.empty() && tag != "!" && tag != "?") {
      problems_.Add(node.place, "tag " + tag + ": expected a plain value");
    }
    Put(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    Open(Make(mark, Node::Kind::kSequence));
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    Open(Make(mark, Node::Kind::kMap));
  }
  void OnMapEnd() override { Close(); }

 private:
  /// A container being filled. In a map keys and values alternate.
  struct Level {
    Node node;
    Node key;
    bool has_key = false;
  };

  Node Make(const YAML::Mark& mark, Node::Kind kind) const {
    Node node;
    node.kind = kind;
    node.place = {source_, mark.line + 1, mark.column + 1};
    return node;
  }
  void Open(Node node) {
    if (levels_.size() >= kMaxDepth) {
      throw YAML::Exception(YAML::Mark::null_mark(), "more than " + std::to_string(kMaxDepth) +
                                                         " levels of lists and sections");
    }
    levels_.push_back({std::move(node), {}, false});
  }
  void Close() {
    Node done = std::move(levels_.back().node);
    levels_.pop_back();
    Put(std::move(done));
  }
  void Put(Node node) {
    if (levels_.empty()) {
      root = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (level.node.kind == Node::Kind::kSequence) {
      level.node.items.push_back(std::move(node));
    } else if (!level.has_key) {
      level.key = std::move(node);
      level.has_key = true;
    } else {
      level.has_key = false;
      PutEntry(level, std::move(node));
    }
  }
  void PutEntry(Level& level, Node value) {
    // The mark of a value that is not there points behind it, often into the next line.
    if (value.kind == Node::Kind::kNull) value.place = level.key.place;
    if (level.key.kind != Node::Kind::kScalar) {
      problems_.Add(level.key.place, level.key.Shown() + ": expected a key (a plain word)");
    } else if (const Node* first = level.node.Find(level.key.text)) {
      problems_.Add(level.key.place, PathToKey() + " = " + value.Shown() +
                                         ": duplicate key: expected once (first at line " +
                                         std::to_string(first->place.line) + ")");
    } else {
      level.node.keys.push_back(std::move(level.key));
      level.node.items.push_back(std::move(value));
    }
  }
  /// "cameras[1].gain_db" of the key that is being read.
  std::string PathToKey() const {
    std::string path;
    for (const Level& level : levels_) {
      if (level.node.kind == Node::Kind::kSequence) {
        path += "[" + std::to_string(level.node.items.size()) + "]";
      } else {
        path += (path.empty() ? "" : ".") + level.key.Shown();
      }
    }
    return path;
  }

  const std::string& source_;
  Problems& problems_;
  std::vector<Level> levels_;
};

void SetSource(Node& node, const std::string& source) {
  node.place = {source, 0, 0};
  for (Node& key : node.keys) SetSource(key, source);
  for (Node& item : node.items) SetSource(item, source);
}

/// "a.b[2].c" -> {"a", "b", "2", "c"}; empty if malformed.
std::vector<std::string> SplitPath(std::string_view path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.' || c == '[') {
      parts.emplace_back();
    } else if (c != ']') {
      parts.back() += c;
    }
  }
  const bool malformed =
      std::any_of(parts.begin(), parts.end(), [](const std::string& p) { return p.empty(); });
  return malformed ? std::vector<std::string>{} : parts;
}

Node ParseOverrideValue(const std::string& value, const std::string& source, Problems& problems) {
  Node node;
  if (!value.empty() && std::string_view("[{\"'").find(value.front()) != std::string_view::npos) {
    Problems own;
    node = ParseYaml(value, source, own);
    if (!own.empty()) problems.Add({source, 0, 0}, "expected a YAML value after =");
  } else {
    node.kind = Node::Kind::kScalar;
    node.text = value;
  }
  SetSource(node, source);
  return node;
}

}  // namespace

const Node* Node::Find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].text == key) return &items[i];
  }
  return nullptr;
}

Node* Node::Find(std::string_view key) {
  return const_cast<Node*>(static_cast<const Node*>(this)->Find(key));
}

std::string Node::Shown() const {
  switch (kind) {
    case Kind::kNull:
      return "(nothing)";
    case Kind::kSequence:
      return "[...]";
    case Kind::kMap:
      return "{...}";
    case Kind::kScalar:
      break;
  }
  std::string shown = text.substr(0, 60);
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  if (text.size() > 60) shown += "...";
  return quoted || text.empty() ? '"' + shown + '"' : shown;
}

Node ParseYaml(std::string_view text, const std::string& source, Problems& problems) {
  TreeBuilder builder(source, problems);
  builder.root.place = {source, 1, 1};
  if (text.size() > kMaxBytes) {
    problems.Add({source, 1, 1}, "larger than 1 MiB: expected a configuration file");
    return builder.root;
  }
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
    const std::string_view before = text.substr(0, nul);
    const auto lines = std::count(before.begin(), before.end(), '\n');
    problems.Add({source, static_cast<int>(lines) + 1, 1}, "binary data: expected YAML text");
    return builder.root;
  }
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    Node first = std::move(builder.root);
    builder.root = Node{};
    if (parser.HandleNextDocument(builder)) {
      problems.Add({source, builder.root.place.line, builder.root.place.column},
                   "second YAML document: expected one (remove the --- before it)");
    }
    return first;
  } catch (const YAML::Exception& e) {
    // Null marks have line -1.
    problems.Add({source, std::max(e.mark.line, 0) + 1, std::max(e.mark.column, 0) + 1},
                 "not YAML: " + e.msg + ": expected \"key: value\" lines");
  } catch (const std::exception& e) {
    problems.Add({source, 1, 1}, std::string("not YAML: ") + e.what());
  }
  return builder.root;
}

void ApplyOverride(Node& root, const std::string& assignment, Problems& problems) {
  const std::string source = "--set " + assignment.substr(0, 120);
  const std::size_t equals = assignment.find('=');
  const std::vector<std::string> parts =
      equals == std::string::npos ? std::vector<std::string>{}
                                  : SplitPath(std::string_view(assignment).substr(0, equals));
  if (parts.empty()) {
    problems.Add({source, 0, 0}, "expected dotted.key=value");
    return;
  }
  Node* node = &root;
  for (const std::string& part : parts) {
    if (node->kind == Node::Kind::kNull) {
      node->kind = Node::Kind::kMap;
      if (node->place.source.empty()) node->place = {source, 0, 0};
    }
    if (node->kind == Node::Kind::kMap) {
      if (node->Find(part) == nullptr) {
        Node key;
        key.kind = Node::Kind::kScalar;
        key.text = part;
        key.place = {source, 0, 0};
        Node value;
        value.place = key.place;
        node->keys.push_back(std::move(key));
        node->items.push_back(std::move(value));
      }
      node = node->Find(part);
    } else if (node->kind == Node::Kind::kSequence) {
      std::size_t index = 0;
      const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
      if (error != std::errc{} || end != part.data() + part.size() || index >= node->items.size()) {
        problems.Add({source, 0, 0},
                     part + ": expected an index below " + std::to_string(node->items.size()));
        return;
      }
      node = &node->items[index];
    } else {
      problems.Add({source, 0, 0}, part + ": expected a section above it, not " + node->Shown());
      return;
    }
  }
  *node = ParseOverrideValue(assignment.substr(equals + 1), source, problems);
}

}  // namespace kawara::core::config
