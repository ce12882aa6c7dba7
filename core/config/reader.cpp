#include "core/config/reader.hpp"

#include <algorithm>

namespace kawara::core::config {

void Reader::ReportUnknownKeys() {
  for (std::size_t i = 0; i < section_.keys.size(); ++i) {
    const Node& key = section_.keys[i];
    const auto same = [&](const char* known) { return key.text == known; };
    if (std::any_of(known_.begin(), known_.end(), same)) continue;
    const char* near = NearestName(key.text, known_);
    problems_.Add(key.place, JoinPath(path_, key.Shown().c_str()) + " = " +
                                 section_.items[i].Shown() + ": unknown key: expected " +
                                 (near != nullptr ? JoinPath(path_, near) + "?"
                                                  : "one of " + JoinNames(known_)));
  }
}

}  // namespace kawara::core::config
