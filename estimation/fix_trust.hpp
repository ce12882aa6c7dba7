#pragma once
#include <Eigen/Core>
#include <array>

#include "core/time.hpp"
#include "estimation/measurement_models.hpp"
#include "estimation/navigation_config.hpp"

namespace kawara::estimation {

/// Whether a GNSS position is to be believed, judged by the prediction BEFORE the update: a
/// receiver that fixed its ambiguities wrongly says "1 cm" all the same. One contradiction ends
/// belief in that grade; agreement for `readmit_s` restores it; contradiction for `concede_s` on
/// end means that the filter, not the receiver, is wrong. Copyable. One thread.
class FixTrust {
 public:
  enum class Verdict { kUse, kRefuse, kConcede };

  /// `residual_ned_m`: measured minus predicted; `nis`: the same, normalised; `drifted`: the
  /// prediction comes out of an outage through which nothing but the inertial unit led.
  Verdict Judge(core::GpsTime stamp, GnssGrade grade, const Eigen::Vector3d& residual_ned_m,
                double nis, bool drifted, const TrustConfig& config);
  /// Positions of this grade are being refused.
  bool refusing(GnssGrade grade) const { return of(grade).refusing; }
  /// They agree again, but not for long enough.
  bool on_probation(GnssGrade grade) const { return of(grade).agreed_since.IsSet(); }

 private:
  struct Record {
    bool refusing = false;
    core::GpsTime refused_since;
    double patience_s = 0.0;
    core::GpsTime agreed_since;
  };
  const Record& of(GnssGrade grade) const { return records_[static_cast<std::size_t>(grade)]; }

  std::array<Record, 3> records_;
};

}  // namespace kawara::estimation
