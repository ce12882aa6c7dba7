#include "drivers/v4l2_controls.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <system_error>

namespace kawara::drivers {
namespace {

constexpr int kMaxControls = 1024;  ///< the end of a list that does not end
constexpr std::int64_t kMaxMenu = 1024;

V4l2Control::Kind KindOf(std::uint32_t type) {
  using Kind = V4l2Control::Kind;
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_INTEGER64:
      return Kind::kInteger;
    case V4L2_CTRL_TYPE_BOOLEAN:
      return Kind::kBoolean;
    case V4L2_CTRL_TYPE_MENU:
      return Kind::kMenu;
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return Kind::kIntegerMenu;
    case V4L2_CTRL_TYPE_BUTTON:
      return Kind::kButton;
    case V4L2_CTRL_TYPE_BITMASK:
      return Kind::kBitmask;
    case V4L2_CTRL_TYPE_STRING:
      return Kind::kText;
    default:
      return Kind::kOther;
  }
}

bool IsMenu(const V4l2Control& control) {
  return control.kind == V4l2Control::Kind::kMenu ||
         control.kind == V4l2Control::Kind::kIntegerMenu;
}

std::optional<std::int64_t> NumberIn(std::string_view text) {
  int base = 10;
  if (text.starts_with("0x")) {
    text.remove_prefix(2);
    base = 16;
  }
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

}  // namespace

bool V4l2Control::read_only() const { return (flags & V4L2_CTRL_FLAG_READ_ONLY) != 0; }
bool V4l2Control::write_only() const { return (flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0; }
bool V4l2Control::inactive() const { return (flags & V4L2_CTRL_FLAG_INACTIVE) != 0; }

std::string V4l2ControlName(std::string_view title) {
  std::string name;
  bool gap = false;
  for (const char c : title) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u) == 0) {
      gap = true;
      continue;
    }
    if (gap && !name.empty()) name += '_';
    gap = false;
    name += static_cast<char>(std::tolower(u));
  }
  return name;
}

std::string RangeText(const V4l2Control& control) {
  using Kind = V4l2Control::Kind;
  switch (control.kind) {
    case Kind::kBoolean:
      return "0 or 1";
    case Kind::kButton:
      return "(button: 1 presses it)";
    case Kind::kText:
    case Kind::kOther:
      return "(not a number: not supported here)";
    case Kind::kMenu:
    case Kind::kIntegerMenu: {
      std::string text;
      for (const auto& [value, name] : control.menu) {
        text += (text.empty() ? "one of " : ", ") + std::to_string(value) + " (" + name + ")";
      }
      return text;
    }
    case Kind::kBitmask:
      return "bits of " + std::to_string(control.maximum);
    case Kind::kInteger:
      break;
  }
  std::string text = std::to_string(control.minimum) + ".." + std::to_string(control.maximum);
  if (control.step > 1) text += " in steps of " + std::to_string(control.step);
  return text;
}

core::Expected<V4l2Controls> V4l2Controls::Read(const V4l2Device& device) {
  V4l2Controls controls(device);
  std::uint32_t id = 0;
  for (int i = 0; i < kMaxControls; ++i) {
    v4l2_query_ext_ctrl query{};
    query.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
    const int error = device.node().Ioctl(VIDIOC_QUERY_EXT_CTRL, &query);
    if (error == EINVAL || error == ENOTTY) break;  // the end, or a camera without controls
    if (error != 0) return tl::unexpected(device.Error(VIDIOC_QUERY_EXT_CTRL, error));
    id = query.id;
    if (query.type == V4L2_CTRL_TYPE_CTRL_CLASS || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0)
      continue;
    V4l2Control control;
    control.id = query.id;
    control.title = {query.name, strnlen(query.name, sizeof query.name)};
    control.name = V4l2ControlName(control.title);
    control.kind = KindOf(query.type);
    control.minimum = query.minimum;
    control.maximum = control.kind == V4l2Control::Kind::kBitmask
                          ? static_cast<std::uint32_t>(query.maximum)
                          : query.maximum;
    control.default_value = query.default_value;
    control.step = query.step;
    control.flags = query.flags;
    control.wide = query.type == V4L2_CTRL_TYPE_INTEGER64;
    if (IsMenu(control)) controls.AddMenu(control);
    controls.controls_.push_back(std::move(control));
  }
  return controls;
}

void V4l2Controls::AddMenu(V4l2Control& control) const {
  const std::int64_t end = std::min(control.maximum, control.minimum + kMaxMenu);
  for (std::int64_t value = control.minimum; value <= end; ++value) {
    v4l2_querymenu item{};
    item.id = control.id;
    item.index = static_cast<std::uint32_t>(value);
    if (device_->node().Ioctl(VIDIOC_QUERYMENU, &item) != 0) continue;  // a gap in the menu
    if (control.kind == V4l2Control::Kind::kIntegerMenu) {
      std::int64_t number = 0;  // the struct is packed
      std::memcpy(&number, &item.value, sizeof number);
      control.menu.emplace_back(value, std::to_string(number));
    } else {
      const char* const name = reinterpret_cast<const char*>(item.name);
      control.menu.emplace_back(value, std::string(name, strnlen(name, sizeof item.name)));
    }
  }
}

const V4l2Control* V4l2Controls::Find(std::string_view name) const {
  const auto number = name.starts_with("0x") ? NumberIn(name) : std::nullopt;
  for (const V4l2Control& control : controls_) {
    if (control.name == name || (number && control.id == *number)) return &control;
  }
  return nullptr;
}

core::Expected<std::int64_t> V4l2Controls::Get(std::string_view name) const {
  const V4l2Control* const control = Find(name);
  if (control == nullptr) return tl::unexpected(NoSuch(name));
  return GetValue(*control);
}

core::Expected<std::int64_t> V4l2Controls::GetValue(const V4l2Control& control) const {
  using Kind = V4l2Control::Kind;
  if (control.write_only() || control.kind == Kind::kButton || control.kind == Kind::kText ||
      control.kind == Kind::kOther) {
    return tl::unexpected(Refusal(control, "cannot be read as a number"));
  }
  v4l2_ext_control value{};
  value.id = control.id;
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &value;
  if (const int error = device_->node().Ioctl(VIDIOC_G_EXT_CTRLS, &list); error != 0) {
    return tl::unexpected(device_->Error(VIDIOC_G_EXT_CTRLS, error));
  }
  const std::int64_t wide = value.value64;  // copies: the struct is packed
  const std::int32_t narrow = value.value;
  if (control.wide) return wide;
  if (control.kind == Kind::kBitmask) return static_cast<std::uint32_t>(narrow);
  return narrow;
}

core::Expected<void> V4l2Controls::Set(std::string_view name, std::string_view value) const {
  const V4l2Control* const control = Find(name);
  if (control == nullptr) return tl::unexpected(NoSuch(name));
  const auto number = Parse(*control, value);
  if (!number) return tl::unexpected(number.error());
  return Set(*control, *number);
}

core::Expected<void> V4l2Controls::Set(const V4l2Control& control, std::int64_t number) const {
  v4l2_ext_control value{};
  value.id = control.id;
  if (control.wide) {
    value.value64 = number;
  } else {
    value.value = static_cast<std::int32_t>(number);
  }
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &value;
  const int error = device_->node().Ioctl(VIDIOC_S_EXT_CTRLS, &list);
  if (error == 0) return {};
  if (error == EBUSY) {
    return tl::unexpected(Refusal(control, "cannot be changed now (grabbed while streaming?)"));
  }
  if (error == EACCES || error == EINVAL || error == ERANGE) {
    return tl::unexpected(Refusal(
        control, "the camera refuses " + std::to_string(number) + ": expected " +
                     RangeText(control) + (control.inactive() ? " (an automatic has it)" : "")));
  }
  return tl::unexpected(device_->Error(VIDIOC_S_EXT_CTRLS, error));
}

core::Expected<void> V4l2Controls::Set(const V4l2Settings& settings) const {
  std::string problems;
  core::ErrorCode code = core::ErrorCode::kInvalidArgument;
  for (const bool switches : {true, false}) {
    for (const auto& [name, value] : settings) {
      const V4l2Control* const control = Find(name);
      const bool is_switch =
          control != nullptr && (IsMenu(*control) || control->kind == V4l2Control::Kind::kBoolean);
      if (is_switch != switches) continue;
      const auto set = Set(name, value);
      if (set) continue;
      code = set.error().code;
      problems += (problems.empty() ? "" : "; ") + set.error().message;
    }
  }
  if (problems.empty()) return {};
  return core::Fail(code, problems);
}

core::Expected<std::int64_t> V4l2Controls::Parse(const V4l2Control& control,
                                                 std::string_view text) const {
  using Kind = V4l2Control::Kind;
  if (control.read_only()) return tl::unexpected(Refusal(control, "can only be read"));
  if (control.kind == Kind::kButton) return 1;
  if (control.kind == Kind::kText || control.kind == Kind::kOther) {
    return tl::unexpected(Refusal(control, "is not a number: not supported here"));
  }
  auto number = NumberIn(text);
  if (control.kind == Kind::kBoolean && !number) {
    const std::string word = Lower(text);
    if (word == "true" || word == "on" || word == "yes") number = 1;
    if (word == "false" || word == "off" || word == "no") number = 0;
  }
  bool valid = number.has_value();
  if (IsMenu(control)) {
    valid = false;
    for (const auto& [value, name] : control.menu) {
      if ((number && *number == value) || (!number && Lower(name) == Lower(text))) {
        number = value;
        valid = true;
        break;
      }
    }
  } else if (control.kind == Kind::kBitmask) {
    valid = number && *number >= 0 && (*number & ~control.maximum & 0xFFFFFFFF) == 0;
  } else if (number) {
    valid = *number >= control.minimum && *number <= control.maximum &&
            (control.step <= 1 ||
             static_cast<std::uint64_t>(*number - control.minimum) % control.step == 0);
  }
  if (valid) return *number;
  return tl::unexpected(
      Refusal(control, "= " + std::string(text) + ": expected " + RangeText(control)));
}

core::Error V4l2Controls::NoSuch(std::string_view name) const {
  std::string names;
  for (const V4l2Control& control : controls_) names += " " + control.name;
  return {core::ErrorCode::kNotFound,
          "camera " + device_->path() + " has no control \"" + std::string(name) + "\"" +
              (names.empty() ? ": it has no controls at all" : "; it has:" + names)};
}

core::Error V4l2Controls::Refusal(const V4l2Control& control, const std::string& why) const {
  return {core::ErrorCode::kInvalidArgument,
          "camera " + device_->path() + ": control " + control.name + " " + why};
}

std::string V4l2Controls::ValueText(const V4l2Control& control) const {
  const auto value = GetValue(control);
  if (!value) return control.write_only() || control.kind == V4l2Control::Kind::kButton ? "-" : "?";
  for (const auto& [number, name] : control.menu) {
    if (number == *value) return std::to_string(number) + " (" + name + ")";
  }
  return std::to_string(*value);
}

}  // namespace kawara::drivers
