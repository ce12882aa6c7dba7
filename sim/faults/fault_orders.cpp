#include "sim/faults/fault_orders.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace kawara::sim {
namespace {

constexpr std::size_t kLongestText = 1000;

std::string Printable(std::string_view text) {
  std::string line(text);
  for (char& c : line) {
    if (c == '\t') c = ' ';
    if (c < ' ' || c > '~') c = '?';
  }
  return line;
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
  text.remove_prefix(begin);
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::string Seconds(core::Duration d) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", core::ToSeconds(d));
  return text.data();
}

/// The same with the present in every item that does not say a time.
std::string WithTimes(std::string_view text, core::Duration since_start) {
  std::string all;
  while (true) {
    const std::size_t semicolon = text.find(';');
    const std::string_view item = Trimmed(text.substr(0, semicolon));
    if (!item.empty() && !item.starts_with("t=")) all += "t=" + Seconds(since_start) + " ";
    all += item;
    if (semicolon == std::string_view::npos) return all;
    all += ";";
    text.remove_prefix(semicolon + 1);
  }
}

}  // namespace

core::Expected<FaultOrder> ParseFaultOrder(std::string_view text, core::Duration since_start) {
  if (text.size() > kLongestText) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "fault order of " + std::to_string(text.size()) + " characters: at most " +
                          std::to_string(kLongestText));
  }
  const std::string line = Printable(text);
  if (Trimmed(line) == "clear") return FaultOrder{.clear = true, .faults = {}};
  // Whole milliseconds, so that an order can be given again as it was understood.
  const core::Duration now =
      core::Milliseconds(std::max<std::int64_t>(since_start.count(), 0) / 1'000'000);
  auto faults = ParseFaults(WithTimes(line, now));
  if (!faults) return tl::unexpected(faults.error());
  for (const Fault& fault : *faults) {
    if (fault.begin + fault.length > since_start) continue;
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      std::string("fault ") + ToString(fault.kind) +
                          ": over before it was ordered (the run is at " + Seconds(now) +
                          " s); leave out t= to begin now");
  }
  return FaultOrder{.clear = false, .faults = std::move(*faults)};
}

std::string ToString(const FaultOrder& order) {
  std::string text = order.clear ? "clear" : "";
  for (const Fault& fault : order.faults) {
    if (!text.empty()) text += "; ";
    text += "t=" + Seconds(fault.begin) + " " + ToString(fault.kind);
    if (HasValue(fault.kind)) {
      std::array<char, 32> value{};
      std::snprintf(value.data(), value.size(), "=%.9g", fault.value);
      text += value.data();
    }
    text += " " + Seconds(fault.length) + "s";
  }
  return text;
}

FaultPlan Applied(const FaultPlan& plan, const FaultOrder& order, core::Duration since_start) {
  std::vector<Fault> faults;
  if (!order.clear) faults = plan.faults();
  std::erase_if(faults, [&](const Fault& f) { return f.begin + f.length <= since_start; });
  faults.insert(faults.end(), order.faults.begin(), order.faults.end());
  return FaultPlan(std::move(faults));
}

bool FaultOrderInbox::Post(FaultOrder order) {
  const std::lock_guard lock(mutex_);
  if (order.clear) planned_ = 0;
  if (planned_ + order.faults.size() > kMostFaults) return false;
  planned_ += order.faults.size();
  orders_.push_back(std::move(order));
  return true;
}

std::vector<FaultOrder> FaultOrderInbox::Take(std::size_t planned) {
  const std::lock_guard lock(mutex_);
  std::vector<FaultOrder> orders = std::exchange(orders_, {});
  planned_ = planned;
  for (const FaultOrder& order : orders) {
    planned_ = (order.clear ? 0 : planned_) + order.faults.size();
  }
  return orders;
}

}  // namespace kawara::sim
