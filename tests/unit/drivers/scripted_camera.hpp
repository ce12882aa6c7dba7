#pragma once
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "drivers/v4l2_camera.hpp"

/// A camera that does what a script says, in the kernel's place: one format, some controls, frames,
/// silence, and an errno for any call. Time passes only by waiting.
namespace kawara::drivers {

struct ScriptedFrame {
  std::uint32_t sequence = 0;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  core::Duration age{};             ///< arrival minus stamp
  std::vector<std::uint8_t> bytes;  ///< empty: a grey picture of the right size
};

struct ScriptedControl {
  std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
  std::string title;
  std::int64_t minimum = 0, maximum = 255, value = 0;
  std::uint32_t flags = 0;
  std::vector<std::string> menu;
};

inline ScriptedFrame Numbered(std::uint32_t sequence) {
  ScriptedFrame frame;
  frame.sequence = sequence;
  return frame;
}

class ScriptedCamera {
 public:
  std::string path = "/dev/video0";
  std::string card = "Scripted", bus_info = "usb-1";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t fourcc = V4L2_PIX_FMT_GREY, width = 4, height = 2, stride = 6;
  std::uint32_t grants_buffers = 4;
  bool multiplanar = false;
  core::MonoTime now = core::MonoTime::FromNs(1'000'000'000'000);
  std::map<std::uint32_t, ScriptedControl> controls;
  std::deque<ScriptedFrame> frames;                 ///< when it is empty, nothing comes
  std::map<unsigned long, std::deque<int>> errors;  ///< by request; 0: this call succeeds

  // What the driver did.
  int opens = 0, closes = 0, mapped = 0, stream_ons = 0, stream_offs = 0, queued = 0;
  std::vector<std::pair<std::string, std::int64_t>> sets;

  void Fail(unsigned long request, int errno_value) { errors[request].push_back(errno_value); }
  std::size_t PictureBytes() const { return std::size_t{stride} * height; }
  V4l2Camera::System System() {
    return {[this](const std::string& wanted) { return Open(wanted); },
            [this] { return std::vector<std::string>{path}; }, [this] { return now; }};
  }
  core::Expected<std::unique_ptr<V4l2Node>> Open(const std::string& wanted);
  int Ioctl(unsigned long request, void* argument);

  std::mutex mutex;  ///< the trigger sets its control from a thread of its own
  std::vector<std::uint8_t> memory = std::vector<std::uint8_t>(8 * 4096);
};

class ScriptedNode final : public V4l2Node {
 public:
  explicit ScriptedNode(ScriptedCamera& camera) : camera_(camera) {}
  ~ScriptedNode() override { ++camera_.closes; }
  int Ioctl(unsigned long request, void* argument) override {
    return camera_.Ioctl(request, argument);
  }
  std::span<std::uint8_t> Map(std::size_t length, std::uint32_t offset) override {
    ++camera_.mapped;
    return {camera_.memory.data() + offset, length};
  }
  void Unmap(std::span<std::uint8_t>) override { --camera_.mapped; }
  Ready Wait(core::Duration timeout) override {
    const std::lock_guard lock(camera_.mutex);
    if (const auto it = camera_.errors.find(VIDIOC_DQBUF);
        it != camera_.errors.end() && !it->second.empty()) {
      return Ready::kError;
    }
    if (!camera_.frames.empty()) return Ready::kFrame;
    camera_.now += timeout;
    return Ready::kNothing;
  }
  core::MonoTime Now() const override { return camera_.now; }

 private:
  ScriptedCamera& camera_;
};

inline core::Expected<std::unique_ptr<V4l2Node>> ScriptedCamera::Open(const std::string& wanted) {
  if (wanted != path) return core::Fail(core::ErrorCode::kNotFound, wanted + ": no such device");
  ++opens;
  return std::make_unique<ScriptedNode>(*this);
}

inline int ScriptedCamera::Ioctl(unsigned long request, void* argument) {
  const std::lock_guard lock(mutex);
  if (auto& list = errors[request]; !list.empty()) {
    const int error = list.front();
    list.pop_front();
    if (error != 0) return error;
  }
  const auto copy_text = [](auto& field, const std::string& text) {
    std::memcpy(field, text.data(), std::min(text.size(), sizeof field - 1));
  };
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& c = *static_cast<v4l2_capability*>(argument);
      copy_text(c.driver, "scripted");
      copy_text(c.card, card);
      copy_text(c.bus_info, bus_info);
      c.capabilities = V4L2_CAP_DEVICE_CAPS;
      c.device_caps = capabilities;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& f = *static_cast<v4l2_fmtdesc*>(argument);
      if (f.index > 0) return EINVAL;
      f.pixelformat = fourcc;
      return 0;
    }
    case VIDIOC_ENUM_FRAMESIZES: {
      auto& s = *static_cast<v4l2_frmsizeenum*>(argument);
      if (s.index > 0) return EINVAL;
      s.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      s.discrete = {width, height};
      return 0;
    }
    case VIDIOC_ENUM_FRAMEINTERVALS: {
      auto& i = *static_cast<v4l2_frmivalenum*>(argument);
      if (i.index > 0) return EINVAL;
      i.type = V4L2_FRMIVAL_TYPE_DISCRETE;
      i.discrete = {1, 10};
      return 0;
    }
    case VIDIOC_S_FMT: {
      auto& f = *static_cast<v4l2_format*>(argument);
      if (f.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
        f.fmt.pix_mp.plane_fmt[0].bytesperline = stride;
        f.fmt.pix_mp.plane_fmt[0].sizeimage = static_cast<std::uint32_t>(PictureBytes());
      } else {
        f.fmt.pix.bytesperline = stride;
        f.fmt.pix.sizeimage = static_cast<std::uint32_t>(PictureBytes());
      }
      return 0;
    }
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& p = *static_cast<v4l2_streamparm*>(argument);
      p.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
      p.parm.capture.timeperframe = {1, 10};
      return 0;
    }
    case VIDIOC_REQBUFS: {
      auto& r = *static_cast<v4l2_requestbuffers*>(argument);
      if (r.count > 0) r.count = grants_buffers;
      queued = 0;
      return 0;
    }
    case VIDIOC_QUERYBUF: {
      auto& b = *static_cast<v4l2_buffer*>(argument);
      if (b.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
        b.m.planes[0].length = 4096;
        b.m.planes[0].m.mem_offset = 4096 * b.index;
      } else {
        b.length = 4096;
        b.m.offset = 4096 * b.index;
      }
      return 0;
    }
    case VIDIOC_QBUF:
      ++queued;
      return 0;
    case VIDIOC_STREAMON:
      ++stream_ons;
      return 0;
    case VIDIOC_STREAMOFF:
      ++stream_offs;
      queued = 0;
      return 0;
    case VIDIOC_DQBUF: {
      if (frames.empty()) return EAGAIN;
      const ScriptedFrame frame = std::move(frames.front());
      frames.pop_front();
      now += core::Milliseconds(100);
      --queued;
      auto& b = *static_cast<v4l2_buffer*>(argument);
      b.index = frame.sequence % grants_buffers;
      b.sequence = frame.sequence;
      b.flags = frame.flags;
      const std::int64_t stamp_ns = (now - frame.age).ns();
      b.timestamp = {stamp_ns / 1'000'000'000, stamp_ns / 1'000 % 1'000'000};
      const auto bytes =
          frame.bytes.empty() ? std::vector<std::uint8_t>(PictureBytes(), 7) : frame.bytes;
      std::copy(bytes.begin(), bytes.end(), memory.begin() + 4096 * b.index);
      const auto used = static_cast<std::uint32_t>(bytes.size());
      if (b.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) {
        b.m.planes[0].bytesused = used;
      } else {
        b.bytesused = used;
      }
      return 0;
    }
    case VIDIOC_QUERY_EXT_CTRL: {
      auto& q = *static_cast<v4l2_query_ext_ctrl*>(argument);
      const auto next = controls.upper_bound(q.id & ~V4L2_CTRL_FLAG_NEXT_CTRL);
      if (next == controls.end()) return EINVAL;
      const ScriptedControl& c = next->second;
      q.id = next->first;
      q.type = c.type;
      copy_text(q.name, c.title);
      q.minimum = c.minimum;
      q.maximum = c.maximum;
      q.step = 1;
      q.flags = c.flags;
      return 0;
    }
    case VIDIOC_QUERYMENU: {
      auto& m = *static_cast<v4l2_querymenu*>(argument);
      const ScriptedControl& c = controls.at(m.id);
      if (m.index >= c.menu.size() || c.menu[m.index].empty()) return EINVAL;
      std::memcpy(&m.name, c.menu[m.index].data(),
                  std::min<std::size_t>(c.menu[m.index].size(), 31));
      return 0;
    }
    case VIDIOC_G_EXT_CTRLS: {
      auto& list = *static_cast<v4l2_ext_controls*>(argument);
      list.controls[0].value = static_cast<std::int32_t>(controls.at(list.controls[0].id).value);
      return 0;
    }
    case VIDIOC_S_EXT_CTRLS: {
      auto& list = *static_cast<v4l2_ext_controls*>(argument);
      ScriptedControl& c = controls.at(list.controls[0].id);
      c.value = list.controls[0].value;
      sets.emplace_back(V4l2ControlName(c.title), c.value);
      return 0;
    }
    default:
      return ENOTTY;
  }
}

}  // namespace kawara::drivers
