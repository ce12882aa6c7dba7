#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "comms/bus.hpp"
#include "onboard/mapper/frame_source.hpp"

namespace kawara::mapper {

struct BusSourceOptions {
  bool live = false;     ///< false: a log, which waits for the mapper and loses nothing
  double step_m = 0.25;  ///< pictures nearer to the last one are not kept
  std::string robot;     ///< only this robot's; empty: the first that is heard
  /// Of the map of an earlier run; empty: the first picture's place.
  std::optional<core::Geodetic> origin;
  const std::atomic<bool>* stop = nullptr;      ///< ends a live bus
  std::function<void(const std::string&)> say;  ///< lines for people
};

/// The robot's own 1st update as the mapper's input: full pictures of channel PHASE1, each with
/// pose, covariance and geometry inside. Live, a thread takes them from the bus as they come; what
/// the mapper has no time for is thinned: while the queue is full, pictures are dropped whole and
/// counted, so that the process never holds more than it can use. A picture's number is its GPS
/// time, so that a run after a kill, or another mission, goes on in the same map.
class BusSource : public FrameSource {
 public:
  /// Waits for the first picture, which tells the geometry. Errors: kFormat: the log has none;
  /// kUnavailable: stopped before one came; those of the bus.
  static core::Expected<std::unique_ptr<BusSource>> Open(std::unique_ptr<comms::Bus> bus,
                                                         const BusSourceOptions& options);
  ~BusSource() override;

  const Rig& rig() const override { return rig_; }
  core::Expected<std::optional<Stop>> Next() override;
  bool live() const override { return options_.live; }
  std::uint64_t left_out() const override { return dropped_; }
  const std::string& robot() const { return robot_; }
  /// Of the first picture.
  const std::string& mission() const { return mission_; }

 private:
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;

  BusSource(std::unique_ptr<comms::Bus> bus, const BusSourceOptions& options)
      : bus_(std::move(bus)), options_(options), robot_(options.robot) {}
  core::Expected<void> Listen();
  void Take(const std::string& robot, const std::string& mission, std::int64_t gps_ns,
            std::span<const std::uint8_t> jpeg);
  bool MakeRig(std::span<const std::uint8_t> jpeg);
  bool asked_to_stop() const { return options_.stop != nullptr && *options_.stop; }
  void Run();

  std::unique_ptr<comms::Bus> bus_;
  BusSourceOptions options_;
  Rig rig_;
  std::string robot_, mission_;
  std::uint64_t last_number_ = 0;
  Eigen::Vector3d last_place_ = Eigen::Vector3d::Zero();
  bool any_ = false;
  std::uint64_t unusable_ = 0;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Stop> waiting_;
  bool ended_ = false;
  core::Expected<void> failed_;
  std::atomic<std::uint64_t> dropped_ = 0;
  std::thread thread_;
};

}  // namespace kawara::mapper
