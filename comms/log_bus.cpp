#include "comms/log_bus.hpp"

#include <algorithm>
#include <thread>
#include <utility>

namespace kawara::comms {
namespace {

constexpr int kMaxBatch = 64;
// A hostile log may have a new channel in every event; remembering this many is enough for any real
// one.
constexpr std::size_t kMaxRememberedChannels = 4096;

}  // namespace

LogBus::LogBus(EventLogReader reader, LogBusOptions options)
    : reader_(std::move(reader)), options_(std::move(options)) {}

core::Expected<void> LogBus::Publish(std::string_view channel, std::span<const std::uint8_t> data) {
  if (!IsChannelName(channel)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "publish: bad channel name '" + std::string(channel) + "'");
  }
  if (options_.published) options_.published(channel, data, {published_++, now_utc_us_});
  return {};
}

core::Expected<void> LogBus::Subscribe(const std::string& channel, Handler handler) {
  try {
    subscriptions_.push_back(
        {std::regex(channel, std::regex::ECMAScript | std::regex::optimize), std::move(handler)});
  } catch (const std::regex_error& e) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "channel pattern '" + channel + "': " + e.what());
  }
  matching_.clear();
  return {};
}

core::Expected<int> LogBus::HandleFor(core::Duration timeout) {
  const core::MonoTime deadline =
      options_.pace > 0.0 ? core::MonoNow() + timeout : core::MonoTime{};
  int delivered = 0;
  for (int i = 0; i < kMaxBatch; ++i) {
    if (!waiting_) waiting_ = reader_.Next();
    if (!waiting_) {
      at_end_ = true;
      break;
    }
    if (options_.pace > 0.0 &&
        !WaitUntilDue(*waiting_, delivered == 0 ? deadline : core::MonoNow()))
      break;
    delivered += Deliver(*waiting_);
    waiting_.reset();
  }
  return delivered;
}

bool LogBus::WaitUntilDue(const LogEvent& event, core::MonoTime deadline) {
  if (!start_mono_.IsSet()) {
    start_mono_ = core::MonoNow();
    start_time_utc_us_ = event.time_utc_us;
  }
  // A log whose clock was set back plays on at once; one with a wild stamp ends no program.
  const double since_start_s =
      (static_cast<double>(event.time_utc_us) - static_cast<double>(start_time_utc_us_)) * 1e-6;
  const core::MonoTime due =
      start_mono_ + core::DurationFromSeconds(std::clamp(since_start_s, 0.0, 1e9) / options_.pace);
  const core::MonoTime until = std::min(due, deadline);
  const core::MonoTime now = core::MonoNow();
  if (until > now) std::this_thread::sleep_for(until - now);
  return due <= std::max(now, until);
}

int LogBus::Deliver(const LogEvent& event) {
  now_utc_us_ = event.time_utc_us;
  const std::vector<std::size_t>& matching = Matching(event.channel);
  for (const std::size_t i : matching) {
    subscriptions_[i].handler(event.channel, event.data, {event.number, event.time_utc_us});
  }
  return matching.empty() ? 0 : 1;
}

const std::vector<std::size_t>& LogBus::Matching(std::string_view channel) {
  const auto known = matching_.find(channel);
  if (known != matching_.end()) return known->second;
  std::vector<std::size_t> matching;
  for (std::size_t i = 0; i < subscriptions_.size(); ++i) {
    if (std::regex_match(channel.begin(), channel.end(), subscriptions_[i].pattern))
      matching.push_back(i);
  }
  if (matching_.size() >= kMaxRememberedChannels) matching_.clear();
  return matching_.emplace(std::string(channel), std::move(matching)).first->second;
}

}  // namespace kawara::comms
