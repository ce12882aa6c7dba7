#pragma once
#include <span>

#include "core/events.hpp"
#include "core/measurements.hpp"
#include "drivers/ahrs400.hpp"
#include "drivers/ahrs400_dialogue.hpp"
#include "onboard/config.hpp"
#include "onboard/core_sink.hpp"

namespace kawara::onboard {

class AhrsListener {
 public:
  virtual ~AhrsListener() = default;
  virtual void OnAhrsSample(const core::AhrsSample& sample) = 0;
};

/// From the AHRS port's bytes to samples, and back: bringing the unit into the configured mode.
/// Real-time safe; one thread; a pure function of its calls.
class AhrsChain : private drivers::Ahrs400Sink {
 public:
  AhrsChain(const AhrsConfig& config, core::Events& events, CoreSink& out, AhrsListener& listener);

  void OnPort(core::MonoTime now, bool opened);
  void OnBytes(core::MonoTime arrival, std::span<const std::uint8_t> bytes);
  void Tick(core::MonoTime now);

  const drivers::Ahrs400Stats& stats() const { return decoder_.stats(); }

 private:
  void OnSample(const core::AhrsSample& sample, drivers::Ahrs400Mode mode) override;
  void OnVoltages(const drivers::Ahrs400Voltages& voltages) override;
  void OnFrozen(core::MonoTime arrival, drivers::Ahrs400Mode mode) override;
  void PumpDialogue();

  core::Events& events_;
  CoreSink& out_;
  AhrsListener& listener_;
  drivers::Ahrs400Decoder decoder_;
  drivers::Ahrs400Dialogue dialogue_;
  bool port_open_ = false;
  core::MonoTime now_;
};

}  // namespace kawara::onboard
