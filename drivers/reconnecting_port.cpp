#include "drivers/reconnecting_port.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

namespace kawara::drivers {

/// One slot handed to and fro between the port's thread and a helper that may take its time.
/// state_ says whose the slot is; nobody waits for the helper except the destructor.
class ReconnectingPort::Opener {
 public:
  Opener() : thread_([this] { Run(); }) {}
  ~Opener() {
    stop_ = true;
    state_.store(kStop);
    state_.notify_one();
    thread_.join();
  }

  void Request(const SerialConfig& config) {
    config_ = config;
    state_.store(kRequested);
    state_.notify_one();
  }
  std::optional<core::Expected<SerialPort>> Take() {
    if (state_.load() != kDone) return std::nullopt;
    std::optional<core::Expected<SerialPort>> result = std::move(result_);
    result_.reset();
    state_.store(kIdle);
    return result;
  }

 private:
  enum State : int { kIdle, kRequested, kDone, kStop };

  void Run() {
    // The creator may be a real-time thread; opening files must not run at its priority.
    const sched_param normal{};
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal);
    while (!stop_) {
      const int state = state_.load();
      if (state != kRequested) {
        state_.wait(state);
        continue;
      }
      result_.emplace(SerialPort::Open(config_));
      int expected = kRequested;  // not if the destructor came in between
      state_.compare_exchange_strong(expected, kDone);
    }
  }

  std::atomic<bool> stop_{false};
  std::atomic<int> state_{kIdle};
  SerialConfig config_;
  std::optional<core::Expected<SerialPort>> result_;
  std::thread thread_;
};

const char* ToString(PortEventKind k) {
  switch (k) {
    case PortEventKind::kOpened:
      return "opened";
    case PortEventKind::kLost:
      return "lost";
    case PortEventKind::kStillMissing:
      return "missing";
    case PortEventKind::kSilent:
      return "silent";
    case PortEventKind::kTalking:
      return "talking";
  }
  return "?";
}

ReconnectingPort::ReconnectingPort(ReconnectConfig config)
    : config_(std::move(config)), backoff_(config_.backoff_min) {
  if (config_.open_in_background) opener_ = std::make_unique<Opener>();
}

ReconnectingPort::~ReconnectingPort() = default;

void ReconnectingPort::Service(core::MonoTime now) {
  if (port_) {
    if (config_.silence.count() > 0 && !silent_ && now - last_byte_ > config_.silence) {
      silent_ = true;
      core::FixedText<200> text(config_.serial.device);
      text.Append(": open, but no byte for ").Append(core::ToSeconds(now - last_byte_), 1);
      text.Append(" s (switched on? cable? baud rate ")
          .Append(port_->granted().baud_bps)
          .Append("?)");
      Push(now, PortEventKind::kSilent, text);
    }
    return;
  }
  if (!missing_since_.IsSet()) missing_since_ = now;
  if (opening_) {
    if (auto result = opener_->Take()) {
      opening_ = false;
      TakeResult(now, std::move(*result));
    }
    return;
  }
  if (next_try_.IsSet() && now < next_try_) return;
  if (opener_) {
    opening_ = true;
    opener_->Request(config_.serial);
  } else {
    TakeResult(now, SerialPort::Open(config_.serial));
  }
}

void ReconnectingPort::TakeResult(core::MonoTime now, core::Expected<SerialPort> result) {
  if (!result) {
    ++counters_.failed_opens;
    next_try_ = now + backoff_;
    backoff_ = std::min(2 * backoff_, config_.backoff_max);
    if (reminded_at_.IsSet() && now - reminded_at_ < config_.reminder) return;
    reminded_at_ = now;
    core::FixedText<200> text;
    if (const core::Duration missing = now - missing_since_; missing > config_.backoff_max) {
      text.Append("missing for ").Append(core::ToSeconds(missing), 0).Append(" s: ");
    }
    Push(now, PortEventKind::kStillMissing, text.Append(result.error().message));
    return;
  }
  port_.emplace(std::move(*result));
  if (port_->config().baud_bps != config_.serial.baud_bps) {
    // The rate was changed while the helper was opening at the old one.
    (void)port_->SetBaud(config_.serial.baud_bps);
  }
  ++counters_.opened;
  backoff_ = config_.backoff_min;
  missing_since_ = {};
  reminded_at_ = {};
  last_byte_ = now;
  silent_ = false;
  const SerialGranted& granted = port_->granted();
  core::FixedText<200> text("opened ");
  text.Append(config_.serial.device);
  std::error_code error;
  const std::string target = std::filesystem::canonical(config_.serial.device, error).string();
  if (!error && target != config_.serial.device) text.Append(" (").Append(target).Append(")");
  text.Append(": ").Append(granted.baud_bps).Append(" ").Append(ToString(granted.format));
  if (granted.format != config_.serial.format) {
    text.Append(", NOT ").Append(ToString(config_.serial.format)).Append(" as asked");
  }
  if (granted.low_latency) text.Append(", low latency");
  Push(now, PortEventKind::kOpened, text);
}

std::size_t ReconnectingPort::Read(core::MonoTime now, std::span<std::uint8_t> buffer) {
  if (!port_) return 0;
  const auto n = port_->Read(buffer, now);
  if (!n) {
    Lose(now, n.error().message);
    return 0;
  }
  if (*n == 0) return 0;
  counters_.bytes_in += *n;
  last_byte_ = now;
  if (silent_) {
    silent_ = false;
    Push(now, PortEventKind::kTalking,
         core::FixedText<200>(config_.serial.device).Append(": bytes again"));
  }
  return *n;
}

std::size_t ReconnectingPort::Write(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  std::size_t taken = 0;
  if (port_) {
    const auto n = port_->Write(bytes);
    if (n) {
      taken = *n;
    } else {
      Lose(now, n.error().message);
    }
  }
  counters_.bytes_out += taken;
  counters_.bytes_not_written += bytes.size() - taken;
  return taken;
}

core::Expected<void> ReconnectingPort::SetBaud(int baud_bps) {
  config_.serial.baud_bps = baud_bps;
  if (!port_) return {};
  return port_->SetBaud(baud_bps);
}

void ReconnectingPort::Reopen(core::MonoTime now, std::string_view why) {
  if (port_) Lose(now, why);
}

void ReconnectingPort::Lose(core::MonoTime now, std::string_view why) {
  port_.reset();  // first of all: see the class comment
  ++counters_.lost;
  backoff_ = config_.backoff_min;
  next_try_ = now + backoff_;
  missing_since_ = now;
  reminded_at_ = {};
  core::FixedText<200> text("lost ");
  text.Append(config_.serial.device).Append(": ").Append(why).Append(" (looking for it every ");
  text.Append(core::ToSeconds(config_.backoff_min), 1).Append("..");
  text.Append(core::ToSeconds(config_.backoff_max), 1).Append(" s)");
  Push(now, PortEventKind::kLost, text);
}

void ReconnectingPort::Push(core::MonoTime now, PortEventKind kind,
                            const core::FixedText<200>& text) {
  if (events_count_ == events_.size()) {  // nobody listens: the oldest gives way
    events_head_ = (events_head_ + 1) % events_.size();
    --events_count_;
  }
  events_[(events_head_ + events_count_) % events_.size()] = {now, kind, text};
  ++events_count_;
}

bool ReconnectingPort::TryPopEvent(PortEvent& out) {
  if (events_count_ == 0) return false;
  out = events_[events_head_];
  events_head_ = (events_head_ + 1) % events_.size();
  --events_count_;
  return true;
}

}  // namespace kawara::drivers
