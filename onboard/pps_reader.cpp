#include "onboard/pps_reader.hpp"

#include "onboard/realtime.hpp"

namespace kawara::onboard {

PpsReader::PpsReader(drivers::PpsSource& source, InputInbox& inbox, core::Counters& counters)
    : source_(source),
      inbox_(inbox),
      teller_(inbox, PortId::kPps, "the pulse line is there"),
      edges_(counters.Register("pps.edges")),
      thread_([this] { Run(); }) {}

PpsReader::~PpsReader() { Stop(); }

void PpsReader::Stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void PpsReader::Run() {
  BecomeBackground("pps", -5);
  while (!stopping_.load(std::memory_order_relaxed)) {
    const auto edge = source_.Next(core::Milliseconds(200));
    if (edge) {
      teller_.Up();
      if (*edge) {
        edges_.Add();
        inbox_.Post(InputKind::kPulse, (*edge)->mono, Pack((*edge)->sequence));
      }
      continue;
    }
    teller_.Down(edge.error().message);
    // The next call tries to connect again; not in a tight loop.
    std::this_thread::sleep_for(core::Milliseconds(200));
  }
}

}  // namespace kawara::onboard
