#pragma once
#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/config/scalars.hpp"

namespace kawara::core::config {

/// Visitor that only collects the keys of a struct.
struct KeyLister {
  std::vector<const char*> keys;
  template <class T, class... Cs>
  void operator()(const char* key, T&, const Cs&...) {
    keys.push_back(key);
  }
  void Require(bool, const char*, const char*) {}
};

template <class T>
concept Visitable = requires(T& t, KeyLister& v) {
  t.Visit(v);
};

template <class T>
inline constexpr bool kIsVector = false;
template <class T>
inline constexpr bool kIsVector<std::vector<T>> = true;
template <class T>
inline constexpr bool kIsOptional = false;
template <class T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
/// Lists of a fixed length.
template <class T>
inline constexpr int kFixedLength = -1;
template <class T, std::size_t N>
inline constexpr int kFixedLength<std::array<T, N>> = static_cast<int>(N);
template <>
inline constexpr int kFixedLength<Eigen::Vector3d> = 3;

template <class E>
std::vector<const char*> EnumNames() {
  std::vector<const char*> names;
  for (const auto& entry : ConfigNames(E{})) names.push_back(entry.name);
  return names;
}

inline std::string JoinPath(const std::string& path, const char* key) {
  return path.empty() ? key : path + "." + key;
}

/// What a field of type T expects, for the message about a missing or wrong one.
template <class T>
std::string ExpectedText(const std::string& path, const Constraints& c) {
  if constexpr (std::is_same_v<T, bool>) {
    return ExpectedBool();
  } else if constexpr (std::is_enum_v<T>) {
    return ExpectedEnum(EnumNames<T>());
  } else if constexpr (std::is_integral_v<T>) {
    return ExpectedInteger(c, static_cast<std::int64_t>(std::numeric_limits<T>::min()),
                           std::is_same_v<T, std::uint64_t>
                               ? std::numeric_limits<std::int64_t>::max()
                               : static_cast<std::int64_t>(std::numeric_limits<T>::max()));
  } else if constexpr (std::is_same_v<T, double>) {
    return ExpectedDouble(c);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return ExpectedString(c);
  } else if constexpr (std::is_same_v<T, Duration>) {
    return ExpectedDuration(path, c);
  } else if constexpr (kIsOptional<T>) {
    return ExpectedText<typename T::value_type>(path, c);
  } else if constexpr (std::is_same_v<T, NamedTexts>) {
    return ExpectedNamedTexts();
  } else if constexpr (kFixedLength<T> >= 0) {
    return "a list of " + std::to_string(kFixedLength<T>) + ", each " +
           ExpectedText<typename T::value_type>(path, c);
  } else if constexpr (kIsVector<T>) {
    return std::string("a list") + (c.not_empty ? " (not empty)" : "") + ", each " +
           ExpectedText<typename T::value_type>(path, c);
  } else {
    static_assert(Visitable<T>, "not a type a configuration can hold");
    KeyLister lister;
    T{}.Visit(lister);
    return "a section with " + JoinNames(lister.keys);
  }
}

/// Visitor that fills one struct from one section of the tree, reporting every mistake on the way.
class Reader {
 public:
  Reader(const Node& section, std::string path, Problems& problems)
      : section_(section), path_(std::move(path)), problems_(problems), before_(problems.size()) {}

  template <class T, class... Cs>
  void operator()(const char* key, T& field, const Cs&... constraints) {
    Constraints all;
    (all.Add(constraints), ...);
    known_.push_back(key);
    const std::string path = JoinPath(path_, key);
    if (const Node* node = section_.Find(key)) {
      ReadValue(*node, path, all, field);
    } else if (!all.optional && !kIsOptional<T>) {
      problems_.Add(section_.place, path + ": missing: expected " + ExpectedText<T>(path, all));
    }
  }

  /// A rule over several fields; asked only when each of them is right by itself.
  void Require(bool holds, const char* key, const char* expected) {
    if (holds || problems_.size() != before_) return;
    const Node* node = section_.Find(key);
    problems_.Add(node != nullptr ? node->place : section_.place,
                  JoinPath(path_, key) + (node != nullptr ? " = " + node->Shown() : "") +
                      ": expected " + expected);
  }

  /// Reports the keys that Visit() did not ask for.
  void ReportUnknownKeys();

 private:
  template <class T>
  void ReadValue(const Node& node, const std::string& path, const Constraints& c, T& out) {
    if constexpr (std::is_same_v<T, bool>) {
      ReadBool(node, path, out, problems_);
    } else if constexpr (std::is_enum_v<T>) {
      std::size_t index = std::numeric_limits<std::size_t>::max();
      ReadEnum(node, path, EnumNames<T>(), index, problems_);
      if (index != std::numeric_limits<std::size_t>::max()) out = ConfigNames(T{})[index].value;
    } else if constexpr (std::is_integral_v<T>) {
      constexpr std::int64_t kMin = static_cast<std::int64_t>(std::numeric_limits<T>::min());
      constexpr std::int64_t kMax = std::is_same_v<T, std::uint64_t>
                                        ? std::numeric_limits<std::int64_t>::max()
                                        : static_cast<std::int64_t>(std::numeric_limits<T>::max());
      std::int64_t value = static_cast<std::int64_t>(out);
      ReadInteger(node, path, c, kMin, kMax, value, problems_);
      out = static_cast<T>(value);
    } else if constexpr (std::is_same_v<T, double>) {
      ReadDouble(node, path, c, out, problems_);
    } else if constexpr (std::is_same_v<T, std::string>) {
      ReadString(node, path, c, out, problems_);
    } else if constexpr (std::is_same_v<T, Duration>) {
      ReadDuration(node, path, c, out, problems_);
    } else if constexpr (kIsOptional<T>) {
      ReadValue(node, path, c, out.emplace());
    } else if constexpr (std::is_same_v<T, NamedTexts>) {
      ReadNamedTexts(node, path, out, problems_);
    } else if constexpr (kFixedLength<T> >= 0 || kIsVector<T>) {
      ReadList(node, path, c, out);
    } else {
      static_assert(Visitable<T>, "not a type a configuration can hold");
      if (node.kind != Node::Kind::kMap) return ReportValue<T>(node, path, c);
      Reader reader(node, path, problems_);
      out.Visit(reader);
      reader.ReportUnknownKeys();
    }
  }

  template <class T>
  void ReadList(const Node& node, const std::string& path, const Constraints& c, T& out) {
    if (node.kind != Node::Kind::kSequence) return ReportValue<T>(node, path, c);
    if constexpr (kIsVector<T>) {
      static_assert(!std::is_same_v<T, std::vector<bool>>, "std::vector<bool> has no elements");
      if (c.not_empty && node.items.empty()) return ReportValue<T>(node, path, c);
      out.assign(node.items.size(), typename T::value_type{});
    } else if (node.items.size() != static_cast<std::size_t>(kFixedLength<T>)) {
      return ReportValue<T>(node, path, c);
    }
    Constraints element = c;
    if constexpr (!std::is_same_v<typename T::value_type, std::string>) element.not_empty = false;
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const std::string element_path = path + "[" + std::to_string(i) + "]";
      if constexpr (kFixedLength<T> >= 0 && !std::is_class_v<typename T::value_type>) {
        auto value = out[static_cast<decltype(out.size())>(i)];
        ReadValue(node.items[i], element_path, element, value);
        out[static_cast<decltype(out.size())>(i)] = value;
      } else {
        ReadValue(node.items[i], element_path, element, out[i]);
      }
    }
  }

  template <class T>
  void ReportValue(const Node& node, const std::string& path, const Constraints& c) {
    problems_.Add(node.place,
                  path + " = " + node.Shown() + ": expected " + ExpectedText<T>(path, c));
  }

  const Node& section_;
  const std::string path_;
  Problems& problems_;
  const std::size_t before_;
  std::vector<const char*> known_;
};

}  // namespace kawara::core::config
