#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/expected.hpp"
#include "drivers/v4l2_device.hpp"

namespace kawara::drivers {

/// One knob of a camera, standard or the maker's own.
struct V4l2Control {
  enum class Kind : std::uint8_t {
    kInteger,
    kBoolean,
    kMenu,
    kIntegerMenu,
    kButton,
    kBitmask,
    kText,
    kOther
  };

  std::uint32_t id = 0;
  std::string name;   ///< as written in configurations: "exposure_time_absolute"
  std::string title;  ///< the device's: "Exposure Time, Absolute"
  Kind kind = Kind::kOther;
  std::int64_t minimum = 0, maximum = 0, default_value = 0;
  std::uint64_t step = 1;
  bool wide = false;                                       ///< its value has 64 bits
  std::uint32_t flags = 0;                                 ///< V4L2_CTRL_FLAG_*
  std::vector<std::pair<std::int64_t, std::string>> menu;  ///< value, its name

  bool read_only() const;
  bool write_only() const;
  bool inactive() const;  ///< an automatic has it now
};

/// What is to be set, in the order it was written.
using V4l2Settings = std::vector<std::pair<std::string, std::string>>;

/// "Exposure Time, Absolute" -> "exposure_time_absolute": as v4l2-ctl writes it.
std::string V4l2ControlName(std::string_view title);
/// "0..255", "0 or 1", "one of 1 (Manual Mode), 3 (Aperture Priority Mode)", "(button: 1 presses
/// it)".
std::string RangeText(const V4l2Control& control);

/// All controls of a device, by name. The list is what the device has at the time of Read(); values
/// are read and written through. One thread.
class V4l2Controls {
 public:
  /// Never fails for want of controls: a camera without any has an empty list.
  static core::Expected<V4l2Controls> Read(const V4l2Device& device);

  const std::vector<V4l2Control>& all() const { return controls_; }
  /// Null: there is none of this name (or 0x... number).
  const V4l2Control* Find(std::string_view name) const;

  /// kNotFound: no such control (and which there are). kInvalidArgument: cannot be read.
  core::Expected<std::int64_t> Get(std::string_view name) const;
  /// `value`: a number, true or false, or the name of a menu's item; a button takes anything.
  /// kNotFound as above; kInvalidArgument: not a value of this control (and which are), or one
  /// that cannot be set.
  core::Expected<void> Set(std::string_view name, std::string_view value) const;
  core::Expected<void> Set(const V4l2Control& control, std::int64_t value) const;
  /// Switches and menus first, since they decide whether others can be set at all ("manual" before
  /// the exposure), each group in the order written. Everything that is wrong is reported at once.
  core::Expected<void> Set(const V4l2Settings& settings) const;

  /// The value as people know it: "1 (Manual Mode)".
  std::string ValueText(const V4l2Control& control) const;

 private:
  explicit V4l2Controls(const V4l2Device& device) : device_(&device) {}
  core::Expected<std::int64_t> GetValue(const V4l2Control& control) const;
  core::Expected<std::int64_t> Parse(const V4l2Control& control, std::string_view value) const;
  core::Error NoSuch(std::string_view name) const;
  core::Error Refusal(const V4l2Control& control, const std::string& why) const;
  void AddMenu(V4l2Control& control) const;

  const V4l2Device* device_;
  std::vector<V4l2Control> controls_;
};

}  // namespace kawara::drivers
