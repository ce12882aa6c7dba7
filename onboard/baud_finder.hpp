#pragma once
#include <array>
#include <cstddef>

#include "core/time.hpp"

namespace kawara::onboard {

/// Notices that a serial line runs at the wrong rate (bytes but no message, or an instrument that
/// should answer and does not) and goes through the usual rates until a message comes. Says nothing
/// itself: the owner reports. Real-time safe; one thread.
class BaudFinder {
 public:
  enum class Advice {
    kStay,
    kTryNext,  ///< current() has changed: set it
  };

  BaudFinder(int configured_bps, core::Duration patience);

  void Start(core::MonoTime now);  ///< the port was opened, or the rate set
  void OnMessage() { found_ = true; }
  void OnBytes(std::size_t n) { bytes_ += n; }
  /// `expects_answer`: the instrument was asked something, so silence too speaks against the rate.
  Advice Tick(core::MonoTime now, bool expects_answer);

  bool found() const { return found_; }
  int current() const { return rates_[index_]; }
  int configured() const { return rates_[0]; }
  std::size_t bytes_without_message() const { return bytes_; }
  /// Once round all rates without a message.
  bool exhausted() const { return rounds_ > 0; }

 private:
  static constexpr std::array<int, 7> kUsual{115200, 9600, 38400, 57600, 19200, 4800, 230400};
  std::array<int, 8> rates_{};
  std::size_t count_ = 0;
  std::size_t index_ = 0;
  int rounds_ = 0;
  core::Duration patience_;
  core::MonoTime since_;
  std::size_t bytes_ = 0;
  bool found_ = false;
};

}  // namespace kawara::onboard
