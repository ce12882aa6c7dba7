#include "core/counters.hpp"

#include "core/check.hpp"

namespace kawara::core {
namespace {

bool IsDottedName(std::string_view name) {
  bool at_start = true;  // of a part: a dot may not stand here, nor the end
  for (const char c : name) {
    if (c == '.') {
      if (at_start) return false;
      at_start = true;
    } else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_') {
      at_start = false;
    } else {
      return false;
    }
  }
  return !at_start;
}

}  // namespace

Counter& Counters::Register(std::string_view name) {
  CORE_CHECK(IsDottedName(name));
  const std::lock_guard lock(mutex_);
  auto found = counters_.find(name);
  if (found == counters_.end()) {
    found = counters_.emplace(std::string(name), std::make_unique<Counter>()).first;
  }
  return *found->second;
}

std::vector<Counters::Value> Counters::Snapshot() const {
  const std::lock_guard lock(mutex_);
  std::vector<Value> values;
  values.reserve(counters_.size());
  for (const auto& [name, counter] : counters_) values.push_back({name, counter->value()});
  return values;
}

}  // namespace kawara::core
