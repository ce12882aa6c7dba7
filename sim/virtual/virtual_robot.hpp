#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/counters.hpp"
#include "core/expected.hpp"
#include "drivers/pps.hpp"
#include "onboard/config.hpp"
#include "onboard/robot_core.hpp"
#include "sim/camera/triggered_camera.hpp"
#include "sim/dice.hpp"
#include "sim/virtual/virtual_link.hpp"

namespace kawara::sim {

/// kawara-onboard in virtual time: the same RobotCore between simulated ports, with what a computer
/// adds to it drawn from a seed: how late the loop wakes, how long a frame travels and a picture
/// takes. Everything it says and every input it consumes goes to `emit` in the order and the bytes
/// of the live program's recorder. Without `trigger` there is no camera. One thread.
class VirtualRobot {
 public:
  struct World {
    VirtualPort& gps;
    VirtualPort& ahrs;
    std::function<void(std::uint32_t sequence, core::MonoTime now)> trigger;
    std::function<core::UtcTime(core::MonoTime)> utc_at;  ///< the computer's own clock
    std::function<void(std::string_view channel, std::span<const std::uint8_t> bytes,
                       core::MonoTime now)>
        emit;
  };
  /// `world`'s references must outlive it. Errors: the picture configuration.
  static core::Expected<std::unique_ptr<VirtualRobot>> Create(const onboard::OnboardConfig& config,
                                                              World world, std::uint64_t seed,
                                                              core::MonoTime now);
  ~VirtualRobot();
  VirtualRobot(const VirtualRobot&) = delete;
  VirtualRobot& operator=(const VirtualRobot&) = delete;

  /// What comes from outside, at `now`; it is consumed a little later.
  void OnPulse(core::MonoTime now, const drivers::PpsEdge& edge);
  /// False: no room for it; it is lost.
  bool OnFrame(core::MonoTime now, const TriggeredCamera::Frame& frame);
  void OnCameraPort(core::MonoTime now, bool there);

  /// Does what is due by `now`, which never goes back.
  void Step(core::MonoTime now);
  /// When Step() is due next if nothing comes from outside.
  core::MonoTime NextStep() const;
  /// The end: counters as the live program leaves them.
  void Finish(core::MonoTime now);

  struct Stats {
    std::int64_t inputs = 0;
    std::int64_t fixes = 0;
    std::int64_t poses = 0;
    std::int64_t pictures = 0;
  };
  const Stats& stats() const { return stats_; }

 private:
  class Sink;
  struct Pictures;
  struct Item {
    onboard::InputKind kind = onboard::InputKind::kTick;
    core::MonoTime mono;
    std::vector<std::uint8_t> bytes;
    std::optional<onboard::FrameInput> frame;
  };
  VirtualRobot(const onboard::OnboardConfig& config, World world, std::uint64_t seed,
               core::MonoTime now);
  core::Duration Latency(double least_s, double mean_s);
  void Notice(core::MonoTime at);
  void Run(core::MonoTime now);
  void ServicePort(VirtualLink& link, onboard::InputKind kind, core::MonoTime now);
  void TakeInbox(core::MonoTime now);
  void EverySecond(core::MonoTime now);
  void Post(core::MonoTime at, Item item);
  void PostSystemClock(core::MonoTime now);
  void PostPort(core::MonoTime at, onboard::PortId port, bool there, std::string_view text);
  void Consume(onboard::InputKind kind, core::MonoTime mono, std::span<const std::uint8_t> bytes);

  onboard::OnboardConfig config_;
  World world_;
  Dice dice_;
  core::Counters counters_;
  core::MonoTime now_;  ///< of the step being done
  VirtualLink gps_;
  VirtualLink ahrs_;
  std::unique_ptr<Pictures> pictures_;
  std::unique_ptr<Sink> sink_;
  std::unique_ptr<onboard::RobotCore> core_;
  core::Counter& frames_;
  core::Counter& edges_;

  std::int64_t sequence_ = 0;
  core::MonoTime deadline_, wake_;
  bool noticed_ = false;  ///< the loop is being woken for something that came
  std::multimap<core::MonoTime, Item> inbox_;
  std::multimap<core::MonoTime, std::vector<std::uint8_t>> packets_;  ///< PHASE1 under way
  core::MonoTime next_second_, next_system_clock_;
  Stats stats_;
};

}  // namespace kawara::sim
