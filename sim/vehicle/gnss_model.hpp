#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/measurements.hpp"
#include "sim/dice.hpp"
#include "sim/vehicle/gnss_config.hpp"
#include "sim/vehicle/random_processes.hpp"
#include "sim/vehicle/sky.hpp"

namespace kawara::sim {

/// Whether something stands between a point [ENU, m] and the sky at azimuth (true, clockwise from
/// north) and elevation [rad].
using SkyBlocked =
    std::function<bool(const Eigen::Vector3d& enu_m, double azimuth_rad, double elevation_rad)>;

/// What an RTK receiver makes of its sky: the state of its solution and the error of it, epoch by
/// epoch.
///  * Satellites below the mask or behind something are not used; fewer than four: no solution.
///  * Five or more and fresh corrections: float; it converges, and fixes after a while if there are
///    enough. A fix is lost with the satellites, with old corrections, or by order.
///  * A fix taken under a poor sky may rest on wrong integers: the position jumps by what one or
///  two
///    cycles on two satellites do through the geometry (some decimetres), and the receiver claims
///    centimetres until it notices.
///  * Errors: white + Gauss-Markov by kind of solution, times the dilution of each axis; multipath
///  in
///    proportion to the blocked share of the sky (full size at a half), changing over way and time.
/// Stated deviations know of noise and convergence, not of multipath or wrong integers: as in life.
/// All processes run on in every state, so that a change of state restarts none. One thread.
class GnssModel {
 public:
  GnssModel(const GnssConfig& config, SkyBlocked blocked, std::uint64_t seed);

  struct Epoch {
    core::RtkState rtk = core::RtkState::kNone;
    bool wrong_fix = false;
    int satellites = 0;
    double blocked_share = 0.0;
    double hdop = 0.0;
    double vdop = 0.0;
    Eigen::Vector3d error_ned_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d sd_ned_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_error_ned_mps = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_sd_ned_mps = Eigen::Vector3d::Zero();
  };
  /// Epochs in order. `moved_m`: way of the antenna since the one before.
  Epoch Next(double since_begin_s, const Eigen::Vector3d& antenna_enu_m, double moved_m);

 private:
  /// One kind of solution's noise, for a dilution of 1.
  struct Noise {
    GnssNoise size;
    GaussMarkov wander;
    Eigen::Vector3d Step(double dt_s, Dice& dice) {
      const Eigen::Vector3d slow = size.wander_m * wander.Step(dt_s, dice);
      return slow + size.white_m * NormalVector(dice);
    }
    double Deviation() const;
  };
  bool Ordered(GnssEventKind kind, double t_s) const;
  void LookUp(double t_s, const Eigen::Vector3d& antenna_enu_m, Epoch& epoch);
  core::RtkState StateNow(double t_s, double dt_s, const Epoch& epoch);
  void BeginFloat();
  void BeginFix(bool wrong);
  void DrawWrongFix();

  GnssConfig config_;
  SkyBlocked blocked_;
  Sky sky_;
  Dice dice_, noise_dice_;
  Noise fixed_, float_, differential_, autonomous_;
  GaussMarkov multipath_;
  std::vector<SatelliteDirection> used_;
  std::optional<Geometry> geometry_;

  double last_s_ = 0.0;
  bool started_ = false;
  bool is_fixed_ = true;  ///< it has been switched on long ago
  bool wrong_ = false;
  bool wrong_by_order_ = false;
  double correction_age_s_ = 0.0;
  double float_age_s_ = 0.0;
  double fix_in_s_ = 0.0;                                  ///< of float with enough satellites
  double notices_in_s_ = 0.0;                              ///< that the fix is wrong
  Eigen::Vector3d float_start_ = Eigen::Vector3d::Zero();  ///< in deviations
  Eigen::Vector3d wrong_ned_m_ = Eigen::Vector3d::Zero();
};

}  // namespace kawara::sim
