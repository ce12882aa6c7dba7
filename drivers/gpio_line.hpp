#pragma once
#include <memory>
#include <string>

#include "drivers/trigger_line.hpp"

struct gpiod_chip;
struct gpiod_line;

namespace kawara::drivers {

/// A GPIO output of the kernel's (libgpiod). Setting it is one system call: microseconds on a
/// processor's own pins, more behind I2C or USB.
class GpioLine final : public TriggerLine {
 public:
  static core::Expected<std::unique_ptr<TriggerLine>> Open(const TriggerLineConfig& config);
  ~GpioLine() override;
  GpioLine(const GpioLine&) = delete;
  GpioLine& operator=(const GpioLine&) = delete;
  core::Expected<void> Set(bool active) override;

 private:
  GpioLine(gpiod_chip* chip, gpiod_line* line, std::string name)
      : chip_(chip), line_(line), name_(std::move(name)) {}
  gpiod_chip* chip_;
  gpiod_line* line_;  ///< of chip_
  std::string name_;
};

}  // namespace kawara::drivers
