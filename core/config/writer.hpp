#pragma once
#include <string>

#include "core/config/reader.hpp"

namespace kawara::core::config {

/// Visitor that writes a struct as YAML which reads back to the same struct.
class Writer {
 public:
  explicit Writer(std::size_t indent = 0, std::string path = {})
      : indent_(indent), path_(std::move(path)) {}

  template <class T, class... Cs>
  void operator()(const char* key, T& field, const Cs&...) {
    if constexpr (kIsOptional<T>) {
      if (field) (*this)(key, *field);
    } else {
      text_ += std::string(indent_, ' ') + key + ":";
      WriteAfterKey(JoinPath(path_, key), field);
    }
  }
  void Require(bool, const char*, const char*) {}

  const std::string& text() const { return text_; }

 private:
  template <class T>
  static std::string Scalar(const std::string& path, const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      return value ? "true" : "false";
    } else if constexpr (std::is_enum_v<T>) {
      for (const auto& entry : ConfigNames(T{})) {
        if (entry.value == value) return entry.name;
      }
      return "\"\"";  // not a named value: refused when read back
    } else if constexpr (std::is_integral_v<T>) {
      return std::to_string(value);
    } else if constexpr (std::is_same_v<T, double>) {
      return TextOfDouble(value);
    } else if constexpr (std::is_same_v<T, Duration>) {
      return TextOfDuration(value, path);
    } else if constexpr (std::is_same_v<T, std::string>) {
      return TextOfString(value);
    } else {
      static_assert(kIsVector<T> || kFixedLength<T> >= 0, "lists inside lists hold values only");
      std::string list = "[";
      for (const auto& element : value)
        list += (list.size() > 1 ? ", " : "") + Scalar(path, element);
      return list + "]";
    }
  }

  template <class T>
  void WriteAfterKey(const std::string& path, T& value) {
    if constexpr (Visitable<T>) {
      Writer section(indent_ + 2, path);
      value.Visit(section);
      text_ += section.text().empty() ? std::string(" {}\n") : "\n" + section.text();
    } else if constexpr (std::is_same_v<T, NamedTexts>) {
      text_ += value.empty() ? " {}\n" : "\n";
      for (const auto& [name, text] : value) {
        text_ +=
            std::string(indent_ + 2, ' ') + TextOfString(name) + ": " + TextOfString(text) + "\n";
      }
    } else if constexpr (kIsVector<T> || kFixedLength<T> >= 0) {
      if constexpr (Visitable<typename T::value_type>) {
        WriteSections(path, value);
      } else {
        text_ += " " + Scalar(path, value) + "\n";
      }
    } else {
      text_ += " " + Scalar(path, value) + "\n";
    }
  }

  /// List of structs: "- " takes the place of the first two blanks of each element's first line.
  template <class List>
  void WriteSections(const std::string& path, List& list) {
    if (list.empty()) {
      text_ += " []\n";
      return;
    }
    text_ += "\n";
    for (auto& element : list) {
      Writer section(indent_ + 4, path);
      element.Visit(section);
      std::string body = section.text();
      if (body.empty()) body = std::string(indent_ + 4, ' ') + "{}\n";
      body[indent_ + 2] = '-';
      text_ += body;
    }
  }

  const std::size_t indent_;
  const std::string path_;
  std::string text_;
};

}  // namespace kawara::core::config
