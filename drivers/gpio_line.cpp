#include "drivers/gpio_line.hpp"

#include <gpiod.h>

#include <cerrno>
#include <charconv>
#include <optional>

namespace kawara::drivers {
namespace {

std::optional<unsigned> OffsetOf(const std::string& text) {
  unsigned offset = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), offset);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return {};
  return offset;
}

tl::unexpected<core::Error> ChipError(const std::string& device, int error) {
  const std::string what = "trigger: GPIO chip " + device + ": ";
  if (error == ENOENT || error == ENODEV) {
    return core::Fail(core::ErrorCode::kNotFound,
                      what + "there is none of this name (`gpiodetect` shows those there are)");
  }
  if (error == EACCES || error == EPERM) {
    return core::Fail(core::ErrorCode::kPermission,
                      what +
                          "this user may not use it (group gpio, or a udev rule that gives "
                          "/dev/gpiochip* to it)");
  }
  if (error == ENOTTY) {
    return core::Fail(core::ErrorCode::kInvalidArgument, what + "is not a GPIO chip");
  }
  return tl::unexpected(core::ErrnoError(what + "open", error));
}

}  // namespace

GpioLine::~GpioLine() { gpiod_chip_close(chip_); }

core::Expected<std::unique_ptr<TriggerLine>> GpioLine::Open(const TriggerLineConfig& config) {
  gpiod_chip* const chip = gpiod_chip_open_lookup(config.device.c_str());
  if (chip == nullptr) return ChipError(config.device, errno);
  const auto offset = OffsetOf(config.line);
  gpiod_line* const line =
      offset ? gpiod_chip_get_line(chip, *offset) : gpiod_chip_find_line(chip, config.line.c_str());
  const std::string name = "trigger: line " + config.line + " of GPIO chip " + config.device;
  // From here on the chip is closed with it.
  std::unique_ptr<GpioLine> gpio(new GpioLine(chip, line, name));
  if (line == nullptr) {
    return core::Fail(core::ErrorCode::kNotFound, name + ": there is none; it has " +
                                                      std::to_string(gpiod_chip_num_lines(chip)) +
                                                      " from 0 (`gpioinfo` shows them)");
  }
  const int flags = config.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (gpiod_line_request_output_flags(line, "kawaraban", flags, 0) != 0) {
    const int error = errno;
    if (error == EBUSY) {
      const char* const user = gpiod_line_consumer(line);
      return core::Fail(core::ErrorCode::kUnavailable,
                        name + ": in use by " + (user != nullptr ? user : "another program") +
                            " (stop it, or give the trigger another line)");
    }
    return tl::unexpected(core::ErrnoError(name + ": as an output", error));
  }
  return gpio;
}

core::Expected<void> GpioLine::Set(bool active) {
  if (gpiod_line_set_value(line_, active ? 1 : 0) == 0) return {};
  return tl::unexpected(core::ErrnoError(name_, errno));
}

}  // namespace kawara::drivers
