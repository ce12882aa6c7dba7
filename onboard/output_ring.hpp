#pragma once
#include <cstdint>
#include <span>

#include "core/byte_ring.hpp"
#include "onboard/core_sink.hpp"

namespace kawara::onboard {

/// Carries what the core says from the real-time thread to a slower one: a CoreSink on the one
/// side, the same calls on another CoreSink on the other. Inputs are among them, so a full ring
/// means a hole in the log: refused() must stay 0 and is watched.
class OutputRing : public CoreSink {
 public:
  explicit OutputRing(std::size_t capacity_bytes);
  ~OutputRing() override;
  OutputRing(const OutputRing&) = delete;
  OutputRing& operator=(const OutputRing&) = delete;

  // Real-time side.
  void OnInput(const Input& input) override;
  void OnFrame(const FrameInput& frame, bool selected) override;
  void OnFix(const core::GnssFix& fix) override;
  void OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) override;
  void OnPose(const core::Pose& pose) override;
  void OnNavigation(const estimation::NavigationReport& report) override;
  void OnClock(const estimation::ClockStatus& clock) override;
  void OnEvent(const core::Event& event, core::GpsTime time) override;
  void OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) override;
  void OnPicture(const PictureOrder& order) override;
  void OnExposurePose(const ExposurePose& pose) override;
  // Acting on the world is the real-time thread's own business: not carried.
  void Trigger(std::uint32_t /*sequence*/) override {}
  void Write(PortId /*port*/, std::span<const std::uint8_t> /*bytes*/) override {}
  void SetBaud(PortId /*port*/, int /*baud_bps*/) override {}
  /// Wakes the other side; once per loop, not per record.
  void Ring();

  // Slower side.
  /// Repeats one call on `sink`; false: none left.
  bool TryDeliver(CoreSink& sink);
  int fd() const { return event_fd_; }
  void Acknowledge();

  std::uint64_t refused() const { return ring_.refused(); }

 private:
  enum class Kind : std::uint8_t {
    kInput,
    kFrame,
    kFix,
    kAhrs,
    kPose,
    kNavigation,
    kClock,
    kEvent,
    kNote,
    kPicture,
    kExposurePose
  };
  struct Header {
    Kind kind = Kind::kInput;
    InputKind input = InputKind::kTick;
    bool flag = false;
    std::int64_t number = 0;
    core::MonoTime mono;
    core::GpsTime time;
  };
  template <class T>
  void Push(Kind kind, const T& value, core::GpsTime time = {}, bool flag = false);

  core::ByteRing<Header> ring_;
  int event_fd_ = -1;
  bool rung_ = true;  ///< nothing new since the last Ring()
};

}  // namespace kawara::onboard
