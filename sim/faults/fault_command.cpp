#include "sim/faults/fault_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <kawara/command_answer_t.hpp>
#include <kawara/command_t.hpp>
#include <optional>
#include <utility>

#include "comms/lcm_bus.hpp"
#include "comms/typed_bus.hpp"

namespace kawara::sim {
namespace {

constexpr core::Duration kRepeat = core::Milliseconds(300);
constexpr core::Duration kListen = core::Milliseconds(100);
/// So many answers are kept for orders that come again.
constexpr std::size_t kRemembered = 64;
constexpr const char* kVerb = "fault";

std::string AnswerChannel(const std::string& channel) { return channel + ".ANSWER"; }

/// Subscriptions are regular expressions: only what means nothing but itself (and '.').
core::Expected<void> CheckChannel(const std::string& channel) {
  const bool plain = std::all_of(channel.begin(), channel.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
  if (plain && comms::IsChannelName(channel) && comms::IsChannelName(AnswerChannel(channel)))
    return {};
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "command channel '" + channel +
                        "': 1 to 56 letters, digits, '.', '_' or '-', e.g. SIM.FAULT");
}

core::Expected<std::unique_ptr<comms::LcmBus>> OpenBus(const std::string& url,
                                                       const std::string& channel) {
  if (auto named = CheckChannel(channel); !named) return tl::unexpected(named.error());
  return comms::LcmBus::Open({.url = url});
}

}  // namespace

core::Expected<std::unique_ptr<FaultListener>> FaultListener::Start(const std::string& url,
                                                                    const std::string& channel,
                                                                    core::MonoTime begin,
                                                                    bool (*mine)(FaultKind),
                                                                    FaultOrderInbox& inbox) {
  auto bus = OpenBus(url, channel);
  if (!bus) return tl::unexpected(bus.error());
  std::unique_ptr<FaultListener> listener(
      new FaultListener(std::move(*bus), channel, begin, mine, inbox));
  auto subscribed = comms::Subscribe<command_t>(
      *listener->bus_, channel,
      [&self = *listener](const command_t& command, const comms::MessageMeta& /*meta*/) {
        if (command.verb == kVerb) self.OnOrder(command.sequence, command.argument);
      });
  if (!subscribed) return tl::unexpected(subscribed.error());
  listener->thread_ = std::thread([&self = *listener] { self.Run(); });
  return listener;
}

FaultListener::FaultListener(std::unique_ptr<comms::Bus> bus, std::string channel,
                             core::MonoTime begin, bool (*mine)(FaultKind), FaultOrderInbox& inbox)
    : bus_(std::move(bus)),
      channel_(std::move(channel)),
      begin_(begin),
      mine_(mine),
      inbox_(inbox) {}

FaultListener::~FaultListener() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void FaultListener::Run() {
  while (!stopping_.load()) {
    if (const auto handled = bus_->HandleFor(kListen); !handled) {
      std::fprintf(stderr, "kawara-sim: no more fault orders: %s\n",
                   handled.error().message.c_str());
      return;
    }
  }
}

void FaultListener::OnOrder(std::int64_t sequence, const std::string& text) {
  auto known = answered_.find(sequence);
  if (known == answered_.end()) {
    if (answered_.size() >= kRemembered) answered_.clear();
    const auto answer = Obey(text);
    if (!answer) return;
    known = answered_.emplace(sequence, *answer).first;
    std::printf("kawara-sim: fault order %s: %s\n", known->second.taken ? "taken" : "refused",
                known->second.text.c_str());
    std::fflush(stdout);
  }
  command_answer_t answer;
  answer.sequence = sequence;
  answer.taken = known->second.taken ? 1 : 0;
  answer.text = known->second.text;
  if (auto sent = comms::Publish(*bus_, AnswerChannel(channel_), answer); !sent) {
    std::fprintf(stderr, "kawara-sim: fault order not answered: %s\n",
                 sent.error().message.c_str());
  }
}

std::optional<FaultListener::Answer> FaultListener::Obey(const std::string& text) {
  auto order = ParseFaultOrder(text, core::MonoNow() - begin_);
  if (!order) return Answer{false, order.error().message};
  const auto own = std::count_if(order->faults.begin(), order->faults.end(),
                                 [&](const Fault& fault) { return mine_(fault.kind); });
  if (own == 0 && !order->clear) return std::nullopt;
  if (own < std::ssize(order->faults)) {
    return Answer{false, "faults of the radio and of the instruments in one order: give two"};
  }
  std::string understood = ToString(*order);
  if (!inbox_.Post(std::move(*order))) {
    return Answer{false, "more than " + std::to_string(FaultOrderInbox::kMostFaults) +
                             " faults are under way; \"clear\" ends them"};
  }
  return Answer{true, std::move(understood)};
}

core::Expected<FaultAnswer> SendFaultOrder(const std::string& url, const std::string& channel,
                                           const std::string& text, core::Duration patience,
                                           const std::atomic<bool>& stop) {
  auto bus = OpenBus(url, channel);
  if (!bus) return tl::unexpected(bus.error());
  command_t order;
  // Another one for every order of every process.
  order.sequence = core::MonoNow().ns() / 1000 * 4'194'304 + getpid() % 4'194'304;
  order.verb = kVerb;
  order.argument = text;
  std::optional<FaultAnswer> answer;
  auto subscribed = comms::Subscribe<command_answer_t>(
      **bus, AnswerChannel(channel),
      [&](const command_answer_t& message, const comms::MessageMeta& /*meta*/) {
        if (message.sequence == order.sequence) answer = {message.taken != 0, message.text};
      });
  if (!subscribed) return tl::unexpected(subscribed.error());
  const core::MonoTime end = core::MonoNow() + patience;
  while (!answer && core::MonoNow() < end && !stop.load()) {
    if (auto sent = comms::Publish(**bus, channel, order); !sent)
      return tl::unexpected(sent.error());
    const core::MonoTime again = std::min(core::MonoNow() + kRepeat, end);
    for (core::MonoTime now = core::MonoNow(); !answer && now < again; now = core::MonoNow()) {
      if (auto handled = (*bus)->HandleFor(again - now); !handled)
        return tl::unexpected(handled.error());
    }
  }
  if (answer) return *answer;
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(),
                "nobody answered on %s within %.1f s: is a kawara-sim running with --lcm-url and "
                "the same bus (for radio faults: kawara-sim radio)?",
                channel.c_str(), core::ToSeconds(patience));
  return core::Fail(core::ErrorCode::kUnavailable, line.data());
}

}  // namespace kawara::sim
