#include "estimation/fix_trust.hpp"

#include <cmath>

namespace kawara::estimation {

FixTrust::Verdict FixTrust::Judge(core::GpsTime stamp, GnssGrade grade,
                                  const Eigen::Vector3d& residual_ned_m, double nis, bool drifted,
                                  const TrustConfig& config) {
  const bool jumps = residual_ned_m.head<2>().norm() > config.min_jump_horizontal_m ||
                     std::abs(residual_ned_m.z()) > config.min_jump_down_m;
  Record& record = records_[static_cast<std::size_t>(grade)];
  if (jumps && nis > config.fix_gate * (drifted ? config.outage_gate_factor : 1.0)) {
    record.agreed_since = {};
    if (!record.refusing) {
      record.refusing = true;
      record.refused_since = stamp;
      record.patience_s = drifted ? config.outage_concede_s : config.concede_s;
    }
    if (core::ToSeconds(stamp - record.refused_since) < record.patience_s) return Verdict::kRefuse;
    record = {};
    return Verdict::kConcede;
  }
  if (!record.refusing) return Verdict::kUse;
  if (!record.agreed_since.IsSet()) record.agreed_since = stamp;
  if (core::ToSeconds(stamp - record.agreed_since) < config.readmit_s) return Verdict::kRefuse;
  record = {};
  return Verdict::kUse;
}

}  // namespace kawara::estimation
