#include "estimation/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimation/filter_tape.hpp"
#include "estimation/heading_bank.hpp"
#include "estimation/levelling.hpp"
#include "estimation/local_frame.hpp"
#include "estimation/navigation_filter.hpp"
#include "estimation/sample_gate.hpp"
#include "estimation/slot_ring.hpp"
#include "estimation/timed_ring.hpp"

namespace kawara::estimation {
namespace {

constexpr std::size_t kImuRing = 1024;  // 200 Hz for 5 s
constexpr std::size_t kMeasurements = 1024;
constexpr std::size_t kSolutions = 512;
constexpr std::size_t kPlacements = 16;  // seconds
constexpr int kCheckpoints = 32;         // over max_lateness
constexpr double kLongestGap = 2.0;      // s without samples: start anew
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr double kOffsetKnown = 0.02;  // s
/// What is left is carried along velocity and acceleration, exact to a tenth of a millimetre for so
/// small a step; moving the measurements for less would only make their order depend on when they
/// came.
constexpr double kOffsetStep = 0.02;  // s

/// How far new measurements are placed off their epochs. Decided once a second, used for epochs two
/// seconds later: by then no late measurement can change the decision any more, so the same data
/// are placed alike in whatever order they arrive.
struct Placement {
  core::GpsTime time;
  double shift_s = 0.0;           ///< the IMU's clock
  double velocity_delay_s = 0.0;  ///< the receiver's filter holds its velocities back
};
constexpr core::Duration kPlacementAge = core::Seconds(2);

/// A place in time to go back to.
struct Checkpoint {
  NavigationFilter filter;
  std::uint64_t next_sample = 0;
  std::uint64_t solutions = 0;
  std::uint64_t placements = 0;
  std::uint64_t tape = 0;
};

bool Finite(const core::GnssFix& fix) {
  const bool position =
      !fix.has_position ||
      (std::isfinite(fix.antenna.lat_rad) && std::isfinite(fix.antenna.lon_rad) &&
       std::isfinite(fix.antenna.h_ellipsoidal_m) &&
       std::abs(fix.antenna.lat_rad) <= core::kPi / 2.0 && fix.position_cov_enu_m2.allFinite() &&
       fix.position_cov_enu_m2.diagonal().minCoeff() >= 0.0);
  const bool velocity = !fix.has_velocity ||
                        (fix.velocity_enu_mps.allFinite() && fix.velocity_sd_enu_mps.allFinite() &&
                         fix.velocity_enu_mps.norm() < 1000.0);
  return position && velocity && (!fix.has_heading || std::isfinite(fix.heading_rad));
}

}  // namespace

class Navigator::Impl {
 public:
  explicit Impl(const NavigationConfig& config)
      : config_(config),
        spacing_(config.max_lateness / (kCheckpoints - 4)),
        bank_(config_),
        samples_(kImuRing),
        solutions_(kSolutions),
        placements_(kPlacements),
        checkpoints_(kCheckpoints) {
    measurements_.reserve(kMeasurements);
  }

  bool AddImu(const ImuSample& raw) {
    ImuSample sample = raw;
    switch (gate_.Pass(sample, config_.imu, stats_)) {
      case SampleGate::Result::kDrop:
        return false;
      case SampleGate::Result::kRestart:
        Restart();
        break;
      case SampleGate::Result::kPass:
        break;
    }
    if (samples_.end() > 0 && core::ToSeconds(sample.time - samples_.back().time) > kLongestGap) {
      Restart();
    }
    ++stats_.imu_samples;
    samples_.Push(sample);
    Work();
    return true;
  }

  /// A velocity that the receiver's own filter holds back belongs to an earlier instant than the
  /// position beside it.
  void AddFix(const core::GnssFix& fix) {
    const Placement placement = PlacementOf(fix.time);
    if (!fix.has_velocity || placement.velocity_delay_s == 0.0) {
      Add(fix.time, fix, placement.shift_s);
      return;
    }
    core::GnssFix velocity = fix;
    velocity.has_position = false;
    velocity.has_heading = false;
    Add(fix.time, velocity, placement.shift_s + placement.velocity_delay_s);
    core::GnssFix rest = fix;
    rest.has_velocity = false;
    if (rest.has_position || rest.has_heading) Add(fix.time, rest, placement.shift_s);
  }

  template <class T>
  void Add(core::GpsTime time, const T& data, double shift_s = 0.0) {
    NavMeasurement m;
    m.shift_s = shift_s;
    m.stamp = time - core::DurationFromSeconds(m.shift_s);
    m.data = data;
    const core::GpsTime newest = samples_.end() > 0 ? samples_.back().time : core::GpsTime{};
    const bool late = samples_.end() > 0 && m.stamp <= newest;
    if (late && newest - m.stamp > config_.max_lateness) {
      ++stats_.too_late;
      return;
    }
    const auto place = std::upper_bound(
        measurements_.begin(), measurements_.end(), m,
        [](const NavMeasurement& a, const NavMeasurement& b) { return Key(a) < Key(b); });
    if (place != measurements_.begin() && Key(*(place - 1)) == Key(m)) {
      ++stats_.repeated;
      return;
    }
    if (measurements_.size() == kMeasurements) {
      ++stats_.invalid;  // a flood from the future
      return;
    }
    if (late) ++stats_.late_fused;
    measurements_.insert(place, m);
    if (late && filter_ && m.stamp <= filter_->state().stamp) GoBackBefore(m.stamp);
    if (late) Work();
  }

  NavigationStats& own_stats() { return stats_; }
  const NavigationStats& stats() {
    if (!filter_) return stats_;
    combined_ = stats_ + filter_->stats();
    return combined_;
  }
  const NavSolution& latest() const { return latest_; }
  const NavigationFilter* filter() const { return filter_ ? &*filter_ : nullptr; }
  void Record(FilterTape* tape) {
    tape_ = tape;
    if (filter_) filter_->SetTape(tape);
    checkpoints_.Clear();  // a tape begins here
    if (filter_) Save();
  }

  std::optional<NavSolution> At(core::GpsTime t) const {
    if (!filter_ || solutions_.end() == solutions_.begin()) return std::nullopt;
    const std::uint64_t after = solutions_.UpperBound(t);
    if (after == solutions_.begin()) return std::nullopt;
    const NavSolution& before = solutions_[after - 1];
    if (after < solutions_.end()) return Interpolated(before, solutions_[after], t);
    constexpr double kAhead = 0.1;
    if (core::ToSeconds(t - before.time) > kAhead) return std::nullopt;
    return Interpolated(before, before, t);
  }

 private:
  /// Ascending time; at the same instant fix, wheels, attitude.
  static std::pair<core::GpsTime, std::size_t> Key(const NavMeasurement& m) {
    return {m.stamp, m.data.index()};
  }

  void Restart() {
    if (filter_) stats_ = stats_ + filter_->stats();
    if (filter_ && !filter_->lost()) calibrated_ = filter_;
    if (calibrated_) calibrated_->SetTape(nullptr);
    filter_.reset();
    bank_.Stop();
    levelling_ = {};
    measurements_.clear();
    checkpoints_.Clear();
    solutions_.Clear();
    next_sample_ = samples_.end();
    latest_ = {};
    placements_.Clear();
  }

  void Save() {
    checkpoints_.Push({*filter_, next_sample_, solutions_.end(), placements_.end(),
                       tape_ != nullptr ? tape_->end() : 0});
  }

  void GoBackBefore(core::GpsTime stamp) {
    if (checkpoints_.empty() || checkpoints_.front().filter.state().stamp >= stamp) {
      // Nothing that old: it was fused at alignment or lies before it.
      std::erase_if(measurements_, [&](const NavMeasurement& m) { return m.stamp == stamp; });
      ++stats_.too_late;
      --stats_.late_fused;
      return;
    }
    while (checkpoints_.back().filter.state().stamp >= stamp) checkpoints_.Pop();
    const Checkpoint& back = checkpoints_.back();
    filter_ = back.filter;
    next_sample_ = back.next_sample;
    solutions_.Rewind(back.solutions);
    placements_.Rewind(back.placements);
    if (tape_ != nullptr) tape_->Rewind(back.tape);
  }

  /// Everything up to the newest sample, or while aligning up to the oldest instant that a late
  /// measurement may still have.
  void Work() {
    if (!filter_) Align();
    if (filter_) Navigate();
    ForgetOld();
  }

  void Navigate() {
    auto next =
        std::upper_bound(measurements_.begin(), measurements_.end(), filter_->state().stamp,
                         [](core::GpsTime t, const NavMeasurement& m) { return t < m.stamp; });
    while (next_sample_ < samples_.end()) {
      const ImuSample& sample = samples_[next_sample_];
      for (; next != measurements_.end() && next->stamp <= sample.time; ++next) {
        filter_->Advance(sample, next->stamp);
        filter_->Fuse(*next);
      }
      filter_->Advance(sample, sample.time);
      filter_->FinishSample(sample);
      filter_->WriteNode();
      DecidePlacement(sample.time);
      ++next_sample_;
      solutions_.Push(filter_->Solution());
      if (checkpoints_.empty() ||
          sample.time - checkpoints_.back().filter.state().stamp >= spacing_) {
        Save();
      }
    }
    latest_ = solutions_.back();
    if (filter_->lost()) {
      Restart();
      return;
    }
  }

  Placement PlacementOf(core::GpsTime epoch) const {
    const std::uint64_t after = placements_.UpperBound(epoch - kPlacementAge);
    return after == placements_.begin() ? Placement{} : placements_[after - 1];
  }

  void DecidePlacement(core::GpsTime now) {
    const bool first = placements_.end() == placements_.begin();
    Placement next = first ? Placement{} : placements_.back();
    if (!first && now.ns() / kSecondNs == next.time.ns() / kSecondNs) return;
    next.time = now;
    const auto offset = filter_->time_offset();
    if (config_.time_offset_sd_s > 0.0 && offset.sd_s < kOffsetKnown &&
        std::abs(offset.value_s - next.shift_s) > kOffsetStep) {
      next.shift_s = offset.value_s;
    }
    const auto delay = filter_->velocity_delay();
    if (delay.sd_s < kOffsetKnown &&
        std::abs(delay.value_s - next.velocity_delay_s) > kOffsetStep) {
      next.velocity_delay_s = std::max(0.0, delay.value_s);
    }
    placements_.Push(next);
  }

  void Align() {
    auto next = measurements_.begin();
    const core::GpsTime horizon = samples_.back().time - config_.max_lateness;
    while (next_sample_ < samples_.end() && samples_[next_sample_].time <= horizon) {
      const ImuSample& sample = samples_[next_sample_];
      for (; next != measurements_.end() && next->stamp <= sample.time; ++next) {
        if (bank_.running()) {
          bank_.Advance(sample, next->stamp);
          bank_.Fuse(*next);
        } else if (const auto start = levelling_.Add(*next, config_)) {
          bank_.Start(*start, calibrated_ ? &*calibrated_ : nullptr);
        }
      }
      measurements_.erase(measurements_.begin(), next);
      next = measurements_.begin();
      if (bank_.running()) {
        bank_.Advance(sample, sample.time);
        bank_.FinishSample(sample);
      } else {
        levelling_.Add(sample);
      }
      ++next_sample_;
      if (const NavigationFilter* winner = bank_.Winner()) {
        filter_ = *winner;
        filter_->SetHypothesis(false);
        // What a filter before it left on the tape has nothing to do with this one.
        if (tape_ != nullptr) tape_->AddForget(0, kErrorStates);
        filter_->SetTape(tape_);
        bank_.Stop();
        ++stats_.alignments;
        Save();
        return;
      }
    }
    if (bank_.running()) latest_ = bank_.Solution();
  }

  void ForgetOld() {
    if (checkpoints_.empty()) return;
    const core::GpsTime oldest = checkpoints_.front().filter.state().stamp;
    auto keep = measurements_.begin();
    while (keep != measurements_.end() && keep->stamp <= oldest) ++keep;
    measurements_.erase(measurements_.begin(), keep);
  }

  const NavigationConfig config_;
  const core::Duration spacing_;
  SampleGate gate_;
  Levelling levelling_;
  HeadingBank bank_;
  std::optional<NavigationFilter> filter_;
  std::optional<NavigationFilter> calibrated_;  ///< the one before, for what it had learned
  TimedRing<ImuSample> samples_;
  TimedRing<NavSolution> solutions_;
  TimedRing<Placement> placements_;
  std::vector<NavMeasurement> measurements_;  ///< by Key; those a checkpoint may need again
  SlotRing<Checkpoint> checkpoints_;          ///< ascending time
  std::uint64_t next_sample_ = 0;
  NavSolution latest_;
  NavigationStats stats_;  ///< of what happens before the filter, and of the filters before it
  NavigationStats combined_;
  FilterTape* tape_ = nullptr;
};

Navigator::Navigator(const NavigationConfig& config) : impl_(std::make_unique<Impl>(config)) {}
Navigator::~Navigator() = default;

bool Navigator::AddImu(const ImuSample& sample) { return impl_->AddImu(sample); }

void Navigator::AddFix(const core::GnssFix& fix) {
  if (!fix.has_position && !fix.has_velocity && !fix.has_heading) return;
  if (!fix.time.IsSet() || !Finite(fix)) {
    ++impl_->own_stats().invalid;
    return;
  }
  impl_->AddFix(fix);
}

void Navigator::AddOdometry(const OdometrySample& sample) {
  if (!std::isfinite(sample.speed_mps) || !std::isfinite(sample.turn_rate_radps)) {
    ++impl_->own_stats().invalid;
    return;
  }
  impl_->Add(sample.time, sample);
}

void Navigator::AddAttitude(const AttitudeSample& sample) {
  const core::Attitude& a = sample.attitude;
  if (!std::isfinite(a.roll_rad) || !std::isfinite(a.pitch_rad) || !std::isfinite(a.yaw_rad) ||
      !std::isfinite(sample.heading_sd_rad)) {
    ++impl_->own_stats().invalid;
    return;
  }
  impl_->Add(sample.time, sample);
}

const NavSolution& Navigator::Latest() const { return impl_->latest(); }
std::optional<NavSolution> Navigator::At(core::GpsTime t) const { return impl_->At(t); }
const NavigationStats& Navigator::stats() const { return impl_->stats(); }
const NavigationFilter* Navigator::filter() const { return impl_->filter(); }
void Navigator::Record(FilterTape* tape) { impl_->Record(tape); }

}  // namespace kawara::estimation
