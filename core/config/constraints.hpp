#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// What a configuration struct says about its fields. Header only and free of YAML, so that any
/// folder may describe its own settings without linking the loader:
///
///     struct GpsConfig {
///       std::string device;
///       int baud_bps = 115200;
///       core::Duration timeout_s = core::Seconds(3);   // the key carries the unit
///       template <class V>
///       void Visit(V& v) {
///         v("device", device, config::NotEmpty{});
///         v("baud_bps", baud_bps, config::OneOf{9600, 38400, 115200});
///         v("timeout_s", timeout_s, config::Range{0.1, 60.0}, config::Optional{});
///         v.Require(baud_bps > 9600 || timeout_s >= core::Seconds(3), "timeout_s", "at least 3 at
///         9600 baud");
///       }
///     };
///
/// Fields: bool, integers, double, std::string, enums (see EnumName), core::Duration,
/// std::optional<T>, std::vector<T>, std::array<T, N>, Eigen::Vector3d, and structs with Visit;
/// lists of structs too; NamedTexts where the names are not ours.
namespace kawara::core::config {

/// A section whose keys are free ({exposure_time_absolute: 50, ...}), in the order written; each
/// value as its text.
using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// Both ends included. For Duration in the unit of the key; for lists it holds for every element.
struct Range {
  double min = 0.0;
  double max = 0.0;
};

/// The only values allowed; for lists every element must be one of them.
struct OneOf {
  OneOf(std::initializer_list<const char*> values) : texts(values.begin(), values.end()) {}
  OneOf(std::initializer_list<double> values) : numbers(values) {}
  std::vector<std::string> texts;
  std::vector<double> numbers;
};

/// A text of at least one character, a list of at least one element.
struct NotEmpty {};

/// The key may be missing; the field keeps its default. Every other key must be written.
struct Optional {};

/// The written name of one value of an enum. An enum becomes a field type by a function beside it:
///     constexpr auto ConfigNames(Parity) {
///       return std::array{config::EnumName<Parity>{Parity::kNone, "none"},
///       config::EnumName<Parity>{...}};
///     }
template <class E>
struct EnumName {
  E value;
  const char* name;
};

/// All constraints of one field together; made by the visitors.
struct Constraints {
  bool optional = false;
  bool not_empty = false;
  std::optional<Range> range;
  std::optional<OneOf> one_of;

  void Add(const Range& r) { range = r; }
  void Add(const OneOf& o) { one_of = o; }
  void Add(NotEmpty) { not_empty = true; }
  void Add(Optional) { optional = true; }
};

}  // namespace kawara::core::config
