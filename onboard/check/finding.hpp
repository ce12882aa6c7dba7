#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kawara::onboard {

enum class Verdict : std::uint8_t {
  kGood,
  kWeak,   ///< the robot runs, but worse than it could
  kWrong,  ///< something it is configured to do will not work
};

/// One thing looked at: what it is, how it stands and how to mend it, in one line.
struct Finding {
  Verdict verdict = Verdict::kGood;
  std::string subject;  ///< "real-time priority", "gps /dev/ttyUSB0"
  std::string text;
};

using Findings = std::vector<Finding>;

inline Finding Good(std::string subject, std::string text) {
  return {Verdict::kGood, std::move(subject), std::move(text)};
}
inline Finding Weak(std::string subject, std::string text) {
  return {Verdict::kWeak, std::move(subject), std::move(text)};
}
inline Finding Wrong(std::string subject, std::string text) {
  return {Verdict::kWrong, std::move(subject), std::move(text)};
}

}  // namespace kawara::onboard
