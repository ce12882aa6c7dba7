#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/measurements.hpp"
#include "estimation/nav_types.hpp"
#include "estimation/navigation_config.hpp"
#include "estimation/navigation_stats.hpp"

namespace kawara::estimation {

class FilterTape;
class NavigationFilter;

/// RTK-GPS/INS navigation: samples in as they arrive, the solution out at every inertial sample.
///
/// Every measurement is fused at its time of validity: one that arrives late (up to
/// `max_lateness`) takes the filter back to a checkpoint before it and everything since is done
/// again, so that once all have arrived the state is the one of data in order. Until heading and
/// position are known a bank of heading hypotheses runs instead; the solution says kAligning.
///
/// Inertial samples must come in the order of their times; what does not is dropped and counted.
/// All times are GPS; those of inertial samples, wheels and attitudes, one computer's stamps, may
/// be off by a constant, which is estimated. Real-time safe after construction: no allocation, no
/// lock, no exception. Deterministic: it reads no clock. One thread.
class Navigator {
 public:
  explicit Navigator(const NavigationConfig& config);
  ~Navigator();

  /// True: Latest() is new.
  bool AddImu(const ImuSample& sample);
  void AddFix(const core::GnssFix& fix);
  void AddOdometry(const OdometrySample& sample);
  void AddAttitude(const AttitudeSample& sample);

  /// At the newest inertial sample. kNone until there is a position.
  const NavSolution& Latest() const;
  /// At any instant of the last `max_lateness` or so, up to a few inertial intervals ahead of the
  /// newest sample; nothing outside of that or before alignment.
  std::optional<NavSolution> At(core::GpsTime t) const;

  const NavigationStats& stats() const;
  /// The filter itself, to look into; null while aligning.
  const NavigationFilter* filter() const;

  /// From now on the filter's steps are written to `tape` for smoothing; null ends it. The tape may
  /// grow (a smoother over a whole log) or be a ring (a few seconds behind).
  void Record(FilterTape* tape);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::estimation
