#pragma once
#include <string>
#include <string_view>
#include <utility>

#include "core/events.hpp"
#include "onboard/input_inbox.hpp"

namespace kawara::onboard {

/// Tells the core when a port that its reader's thread looks after is gone and when it is back:
/// once each, however often the reader finds it so. One thread.
class PortTeller {
 public:
  /// `is_there` is the line that tells it is back.
  PortTeller(InputInbox& inbox, PortId port, std::string is_there)
      : inbox_(inbox), port_(port), is_there_(std::move(is_there)) {}

  /// `what`: what is there, where that is known.
  void Up(std::string_view what = {}) {
    if (state_ == State::kUp) return;
    Tell(State::kUp, core::Severity::kInfo,
         what.empty() ? is_there_ : is_there_ + ": " + std::string(what));
  }
  void Down(std::string_view why) {
    if (state_ != State::kDown) Tell(State::kDown, core::Severity::kWarnHigh, why);
  }

 private:
  enum class State { kUnknown, kUp, kDown };

  void Tell(State state, core::Severity severity, std::string_view text);

  InputInbox& inbox_;
  PortId port_;
  std::string is_there_;
  State state_ = State::kUnknown;
};

}  // namespace kawara::onboard
