#pragma once
#include <span>
#include <string>
#include <string_view>

#include "core/config/reader.hpp"
#include "core/config/writer.hpp"
#include "core/expected.hpp"

/// Typed, validated YAML: a struct with Visit() is the schema (see constraints.hpp). Start-up only,
/// one thread.
namespace kawara::core::config {

/// The whole file, or one line that says why not and what to do.
Expected<std::string> ReadFile(const std::string& path);

/// Parses and applies overrides; `expected_keys` are for the message about an empty document.
Node MakeTree(std::string_view yaml, const std::string& source,
              std::span<const std::string> overrides, const std::string& expected_keys,
              Problems& problems);

/// Reads a T from YAML text. `source` stands before every message; `overrides` are
/// "dotted.key=value" assignments
/// (--set), applied over the text and validated with it. The error message holds ALL mistakes, one
/// line each:
///     configs/field.yaml:14:9: camera.exposure_us = -3: expected 20..20000
template <class T>
Expected<T> Parse(std::string_view yaml, const std::string& source,
                  std::span<const std::string> overrides = {}) {
  Problems problems;
  T config{};
  const Node root = MakeTree(yaml, source, overrides, ExpectedText<T>("", {}), problems);
  if (root.kind == Node::Kind::kMap) {
    Reader reader(root, "", problems);
    config.Visit(reader);
    reader.ReportUnknownKeys();
  }
  if (!problems.empty()) return Fail(ErrorCode::kFormat, problems.Text());
  return config;
}

/// Parse() of a file. Errors as Parse(), or kNotFound, kPermission, kIo if it cannot be read.
template <class T>
Expected<T> Load(const std::string& path, std::span<const std::string> overrides = {}) {
  Expected<std::string> yaml = ReadFile(path);
  if (!yaml) return tl::unexpected<Error>(yaml.error());
  return Parse<T>(*yaml, path, overrides);
}

/// The configuration as YAML, defaults filled in; Parse() of it gives the same configuration.
template <class T>
std::string Dump(T config) {  // by value: Visit() is one function for reading and writing
  Writer writer;
  config.Visit(writer);
  return writer.text().empty() ? "{}\n" : writer.text();
}

}  // namespace kawara::core::config
