#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/config.hpp"

// Any bytes as a configuration: either a list of mistakes or a value that Dump() carries through
// unchanged. The first line, if it starts with '!', is an override.
namespace {

namespace config = kawara::core::config;

struct Inner {
  std::string text;
  double number = 0.0;
  kawara::core::Duration wait_ms{};
  template <class V>
  void Visit(V& v) {
    v("text", text, config::Optional{});
    v("number", number, config::Optional{});
    v("wait_ms", wait_ms, config::Optional{}, config::Range{-1e6, 1e6});
  }
};

struct Outer {
  Inner inner;
  std::vector<Inner> list;
  std::vector<std::int64_t> numbers;
  std::optional<bool> flag;
  template <class V>
  void Visit(V& v) {
    v("inner", inner, config::Optional{});
    v("list", list, config::Optional{});
    v("numbers", numbers, config::Optional{});
    v("flag", flag);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view text(reinterpret_cast<const char*>(data), size);
  std::vector<std::string> overrides;
  if (text.starts_with('!')) {
    const std::string_view line = text.substr(1, text.find('\n') - 1);
    overrides.emplace_back(line);
    text.remove_prefix(line.size() + 1);
  }
  const auto first = config::Parse<Outer>(text, "fuzz", overrides);
  if (!first) {
    if (first.error().message.empty()) std::abort();
    return 0;
  }
  const std::string dump = config::Dump(*first);
  const auto second = config::Parse<Outer>(dump, "dump");
  if (!second || config::Dump(*second) != dump) std::abort();
  return 0;
}
