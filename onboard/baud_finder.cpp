#include "onboard/baud_finder.hpp"

namespace kawara::onboard {
namespace {

/// So many bytes hold at least one sentence or packet of any instrument we know, if the rate is
/// right.
constexpr std::size_t kEnoughBytes = 300;

}  // namespace

BaudFinder::BaudFinder(int configured_bps, core::Duration patience) : patience_(patience) {
  rates_[count_++] = configured_bps;
  for (const int rate : kUsual) {
    if (rate != configured_bps) rates_[count_++] = rate;
  }
}

void BaudFinder::Start(core::MonoTime now) {
  since_ = now;
  bytes_ = 0;
  found_ = false;
}

BaudFinder::Advice BaudFinder::Tick(core::MonoTime now, bool expects_answer) {
  if (found_ || now - since_ < patience_) return Advice::kStay;
  if (bytes_ < kEnoughBytes && !expects_answer) return Advice::kStay;
  index_ = (index_ + 1) % count_;
  if (index_ == 0) ++rounds_;
  Start(now);
  return Advice::kTryNext;
}

}  // namespace kawara::onboard
