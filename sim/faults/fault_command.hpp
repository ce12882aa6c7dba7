#pragma once
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "comms/bus.hpp"
#include "core/expected.hpp"
#include "core/time.hpp"
#include "sim/faults/fault_orders.hpp"

/// Faults on order over LCM, while the simulator runs: command_t with verb "fault" and the order's
/// text as argument on a channel, answered by command_answer_t on the same with ".ANSWER" behind.
namespace kawara::sim {

constexpr const char* kDefaultFaultChannel = "SIM.FAULT";

/// Listens for orders on a thread of its own, hands what it understands to the inbox, answers every
/// order, and prints a line for it. Orders of faults that are all another simulator's (the radio's,
/// the instruments') it leaves to that one. An order that is repeated (same sequence) is answered
/// again but taken once.
class FaultListener {
 public:
  /// `url` as LCM's, empty: LCM's default. Faults "from now" count from `begin`. `inbox` must
  /// outlive it. Errors: no such bus, no channel name.
  static core::Expected<std::unique_ptr<FaultListener>> Start(const std::string& url,
                                                              const std::string& channel,
                                                              core::MonoTime begin,
                                                              bool (*mine)(FaultKind),
                                                              FaultOrderInbox& inbox);
  ~FaultListener();
  FaultListener(const FaultListener&) = delete;
  FaultListener& operator=(const FaultListener&) = delete;

 private:
  struct Answer {
    bool taken = false;
    std::string text;
  };
  FaultListener(std::unique_ptr<comms::Bus> bus, std::string channel, core::MonoTime begin,
                bool (*mine)(FaultKind), FaultOrderInbox& inbox);
  void Run();
  void OnOrder(std::int64_t sequence, const std::string& text);
  std::optional<Answer> Obey(const std::string& text);

  std::unique_ptr<comms::Bus> bus_;
  std::string channel_;
  core::MonoTime begin_;
  bool (*mine_)(FaultKind);
  FaultOrderInbox& inbox_;
  std::map<std::int64_t, Answer> answered_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

struct FaultAnswer {
  bool taken = false;
  std::string text;
};
/// Sends an order and waits for its answer, repeating it a few times a second. Errors: no such bus;
/// kInvalidArgument, no channel name or not a text that can be sent; kUnavailable, nobody answered
/// within `patience`.
core::Expected<FaultAnswer> SendFaultOrder(const std::string& url, const std::string& channel,
                                           const std::string& text, core::Duration patience,
                                           const std::atomic<bool>& stop);

}  // namespace kawara::sim
