#include "sim/vehicle/gnss_model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geodesy.hpp"

namespace kawara::sim {
namespace {

constexpr int kFloatSatellites = 5;
constexpr int kPoorSky = 8;               ///< fewer satellites than this may be fixed wrongly
constexpr double kMultipathTau_s = 60.0;  ///< standing
constexpr double kL1Cycle_m = 0.190293673;
constexpr double kL2Cycle_m = 0.244210213;
constexpr double kSmallestClaim_m = 0.001;
constexpr double kSmallestVelocityClaim_mps = 0.002;

}  // namespace

double GnssModel::Noise::Deviation() const { return std::hypot(size.white_m, size.wander_m); }

GnssModel::GnssModel(const GnssConfig& config, SkyBlocked blocked, std::uint64_t seed)
    : config_(config),
      blocked_(std::move(blocked)),
      sky_(config.satellites, SeedOf(seed, "sky")),
      dice_(SeedOf(seed, "state")),
      noise_dice_(SeedOf(seed, "noise")),
      fixed_{config.fixed, GaussMarkov(config.fixed.tau_s, noise_dice_)},
      float_{config.floating, GaussMarkov(config.floating.tau_s, noise_dice_)},
      differential_{config.differential, GaussMarkov(config.differential.tau_s, noise_dice_)},
      autonomous_{config.autonomous, GaussMarkov(config.autonomous.tau_s, noise_dice_)},
      multipath_(1.0, noise_dice_) {}

bool GnssModel::Ordered(GnssEventKind kind, double t_s) const {
  return std::any_of(config_.events.begin(), config_.events.end(), [&](const GnssEvent& e) {
    return e.kind == kind && t_s >= e.t_s && t_s < e.t_s + e.length_s;
  });
}

void GnssModel::LookUp(double t_s, const Eigen::Vector3d& antenna_enu_m, Epoch& epoch) {
  used_.clear();
  int above_mask = 0;
  const bool lost = Ordered(GnssEventKind::kLost, t_s);
  for (const SatelliteDirection& s : sky_.At(t_s)) {
    if (s.elevation_rad < config_.mask_deg * core::kRadFromDeg) continue;
    ++above_mask;
    if (lost || (blocked_ && blocked_(antenna_enu_m, s.azimuth_rad, s.elevation_rad))) continue;
    used_.push_back(s);
  }
  geometry_ = GeometryOf(used_);
  epoch.satellites = static_cast<int>(used_.size());
  epoch.blocked_share = above_mask > 0 ? 1.0 - static_cast<double>(used_.size()) / above_mask : 0.0;
  if (geometry_) {
    epoch.hdop = geometry_->hdop;
    epoch.vdop = geometry_->vdop;
  }
}

void GnssModel::BeginFloat() {
  is_fixed_ = wrong_ = false;
  float_age_s_ = 0.0;
  fix_in_s_ = config_.fix_time_s * (0.3 + 0.7 * dice_.Exponential());
  float_start_ = NormalVector(dice_);
}

void GnssModel::BeginFix(bool wrong) {
  is_fixed_ = true;
  wrong_ = wrong;
  if (!wrong) return;
  notices_in_s_ = config_.wrong_fix_s * dice_.Exponential();
  DrawWrongFix();
}

/// One or two cycles on two satellites, carried into the position. Tried until it is an error that
/// a receiver's own tests could overlook: not centimetres, not metres.
void GnssModel::DrawWrongFix() {
  for (int attempt = 0; attempt < 100; ++attempt) {
    std::vector<double> range_errors_m(used_.size(), 0.0);
    for (int k = 0; k < 2; ++k) {
      const auto i = static_cast<std::size_t>(dice_.Next() % used_.size());
      const int cycles = 1 + static_cast<int>(dice_.Next() % 2);
      const double sign = dice_.Uniform() < 0.5 ? -1.0 : 1.0;
      const double length_m = dice_.Uniform() < 0.5 ? kL1Cycle_m : kL2Cycle_m;
      range_errors_m[i] += sign * cycles * length_m;
    }
    wrong_ned_m_ = PositionErrorOf(*geometry_, used_, range_errors_m);
    if (wrong_ned_m_.norm() > 0.1 && wrong_ned_m_.norm() < 1.2) return;
  }
}

core::RtkState GnssModel::StateNow(double t_s, double dt_s, const Epoch& epoch) {
  correction_age_s_ = Ordered(GnssEventKind::kNoCorrections, t_s) ? correction_age_s_ + dt_s : 0.0;
  if (!geometry_) {
    BeginFloat();
    return core::RtkState::kNone;
  }
  if (correction_age_s_ > config_.max_age_s) {
    BeginFloat();
    return core::RtkState::kAutonomous;
  }
  if (epoch.satellites < kFloatSatellites) {
    BeginFloat();
    return core::RtkState::kCodeDifferential;
  }
  // Orders come first, ...
  if (Ordered(GnssEventKind::kWrongFix, t_s)) {
    if (!wrong_by_order_) BeginFix(true);
    wrong_by_order_ = true;
    return core::RtkState::kFixed;
  }
  if (std::exchange(wrong_by_order_, false)) BeginFloat();
  if (Ordered(GnssEventKind::kFloat, t_s) || correction_age_s_ > config_.fix_age_s) {
    if (is_fixed_) BeginFloat();
    float_age_s_ += dt_s;
    return core::RtkState::kFloat;
  }
  // ... then what the receiver finds out for itself.
  if (is_fixed_) {
    if (wrong_) notices_in_s_ -= dt_s;
    const bool noticed = wrong_ && notices_in_s_ <= 0.0;
    if (!noticed && epoch.satellites >= config_.fix_satellites - 1) return core::RtkState::kFixed;
    BeginFloat();
    return core::RtkState::kFloat;
  }
  float_age_s_ += dt_s;
  if (epoch.satellites < config_.fix_satellites) return core::RtkState::kFloat;
  fix_in_s_ -= dt_s;
  if (fix_in_s_ > 0.0) return core::RtkState::kFloat;
  BeginFix(epoch.satellites < kPoorSky && dice_.Uniform() < config_.wrong_fix_share);
  return core::RtkState::kFixed;
}

GnssModel::Epoch GnssModel::Next(double since_begin_s, const Eigen::Vector3d& antenna_enu_m,
                                 double moved_m) {
  const double dt_s = started_ ? since_begin_s - last_s_ : 0.0;
  started_ = true;
  last_s_ = since_begin_s;
  Epoch epoch;
  LookUp(since_begin_s, antenna_enu_m, epoch);
  epoch.rtk = StateNow(since_begin_s, dt_s, epoch);

  const Eigen::Vector3d fixed = fixed_.Step(dt_s, noise_dice_);
  const Eigen::Vector3d floating = float_.Step(dt_s, noise_dice_);
  const Eigen::Vector3d differential = differential_.Step(dt_s, noise_dice_);
  const Eigen::Vector3d autonomous = autonomous_.Step(dt_s, noise_dice_);
  multipath_.Step(dt_s / kMultipathTau_s + moved_m / config_.multipath_length_m, noise_dice_);
  const Eigen::Vector3d velocity = config_.velocity_white_mps * NormalVector(noise_dice_);
  if (epoch.rtk == core::RtkState::kNone) return epoch;

  const Eigen::Vector3d& dop = geometry_->axis_dop;
  const Eigen::Vector3d reflected = std::min(1.0, 2.0 * epoch.blocked_share) * multipath_.value();
  Eigen::Vector3d noise;
  double claimed_m = 0.0;
  switch (epoch.rtk) {
    case core::RtkState::kFixed:
      noise = fixed + config_.phase_multipath_m * reflected;
      claimed_m = fixed_.Deviation();
      break;
    case core::RtkState::kFloat: {
      const double start_m = config_.float_start_m * std::exp(-float_age_s_ / config_.float_tau_s);
      // Carrier phases carry the float solution; of the code's multipath it feels a tenth.
      noise = floating + start_m * float_start_ + 0.1 * config_.code_multipath_m * reflected;
      claimed_m = std::hypot(float_.Deviation(), start_m);
      break;
    }
    case core::RtkState::kCodeDifferential:
      noise = differential + config_.code_multipath_m * reflected;
      claimed_m = differential_.Deviation();
      break;
    default:
      noise = autonomous + config_.code_multipath_m * reflected;
      claimed_m = autonomous_.Deviation();
      break;
  }
  epoch.error_ned_m = noise.cwiseProduct(dop);
  epoch.wrong_fix = epoch.rtk == core::RtkState::kFixed && wrong_;
  if (epoch.wrong_fix) epoch.error_ned_m += wrong_ned_m_;
  epoch.sd_ned_m = (config_.claimed_factor * claimed_m * dop).cwiseMax(kSmallestClaim_m);
  epoch.velocity_error_ned_mps = velocity.cwiseProduct(dop);
  epoch.velocity_sd_ned_mps =
      (config_.velocity_white_mps * dop).cwiseMax(kSmallestVelocityClaim_mps);
  return epoch;
}

}  // namespace kawara::sim
