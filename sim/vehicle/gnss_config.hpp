#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config/constraints.hpp"

namespace kawara::sim {

namespace config = core::config;

/// Something ordered to happen to the receiver; otherwise only walls and the seed decide.
enum class GnssEventKind : std::uint8_t {
  kLost,           ///< no satellites
  kFloat,          ///< carrier ambiguities lost; float until the end, then it fixes anew
  kWrongFix,       ///< fixes on wrong integers and claims centimetres
  kNoCorrections,  ///< the base station's data stop
};
constexpr auto ConfigNames(GnssEventKind /*tag*/) {
  using K = GnssEventKind;
  return std::array{config::EnumName<K>{K::kLost, "lost"}, config::EnumName<K>{K::kFloat, "float"},
                    config::EnumName<K>{K::kWrongFix, "wrong-fix"},
                    config::EnumName<K>{K::kNoCorrections, "no-corrections"}};
}

struct GnssEvent {
  GnssEventKind kind = GnssEventKind::kLost;
  double t_s = 0.0;  ///< from the start of the drive
  double length_s = 5.0;

  template <class V>
  void Visit(V& v) {
    v("kind", kind);
    v("t_s", t_s, config::Range{0.0, 1e6});
    v("length_s", length_s, config::Range{0.1, 1e6}, config::Optional{});
  }
};

/// One kind of solution: white error of each epoch and one that wanders (first-order Gauss-Markov),
/// along an axis whose dilution of precision is 1 (15 satellites under an open sky: about 0.6 north
/// and east, 1.1 down).
struct GnssNoise {
  double white_m = 0.0;
  double wander_m = 0.0;
  double tau_s = 60.0;

  template <class V>
  void Visit(V& v) {
    v("white_m", white_m, config::Range{0.0, 50.0}, config::Optional{});
    v("wander_m", wander_m, config::Range{0.0, 50.0}, config::Optional{});
    v("tau_s", tau_s, config::Range{0.1, 1e5}, config::Optional{});
  }
};

/// An RTK receiver and its sky. Profiles: "ideal" (no errors, always fixed), "z-xtreme" (dual
/// frequency RTK of 2000-2004: fixes in half a minute, may fix wrongly under a poor sky).
struct GnssConfig {
  std::string profile = "ideal";
  double rate_hz = 10.0;
  int satellites = 15;     ///< above the horizon
  double mask_deg = 10.0;  ///< satellites lower than this are not used
  int fix_satellites = 6;  ///< needed to resolve ambiguities; one less to keep them
  GnssNoise fixed, floating, differential, autonomous;
  double float_start_m = 0.0;       ///< standard deviation when a float solution begins ...
  double float_tau_s = 25.0;        ///< ... and how it shrinks to its lasting size
  double fix_time_s = 0.0;          ///< float to fixed, mean: 0.3 of it surely, the rest by chance
  double wrong_fix_share = 0.0;     ///< of fixes taken under a poor sky (below 8 satellites)
  double wrong_fix_s = 12.0;        ///< until the receiver notices, mean
  double fix_age_s = 10.0;          ///< corrections older: float
  double max_age_s = 60.0;          ///< corrections older: autonomous
  double phase_multipath_m = 0.0;   ///< error of fixed solutions where half of the sky is blocked
  double code_multipath_m = 0.0;    ///< of the others
  double multipath_length_m = 0.7;  ///< of way, over which multipath changes
  double velocity_white_mps = 0.0;  ///< along an axis of dilution 1
  double claimed_factor = 1.0;      ///< the receiver's stated deviations against the real ones
  double geoid_m = 37.0;
  std::vector<GnssEvent> events;

  static GnssConfig Named(const std::string& profile);

  template <class V>
  void Visit(V& v) {
    const std::string before = profile;
    v("profile", profile, config::OneOf{"ideal", "z-xtreme"}, config::Optional{});
    if (profile != before) *this = Named(profile);
    v("rate_hz", rate_hz, config::OneOf{1, 2, 4, 5, 10, 20}, config::Optional{});
    v("satellites", satellites, config::Range{4, 40}, config::Optional{});
    v("mask_deg", mask_deg, config::Range{0.0, 60.0}, config::Optional{});
    v("fix_satellites", fix_satellites, config::Range{4, 20}, config::Optional{});
    v("fixed", fixed, config::Optional{});
    v("float", floating, config::Optional{});
    v("differential", differential, config::Optional{});
    v("autonomous", autonomous, config::Optional{});
    v("float_start_m", float_start_m, config::Range{0.0, 10.0}, config::Optional{});
    v("float_tau_s", float_tau_s, config::Range{0.1, 1000.0}, config::Optional{});
    v("fix_time_s", fix_time_s, config::Range{0.0, 1000.0}, config::Optional{});
    v("wrong_fix_share", wrong_fix_share, config::Range{0.0, 1.0}, config::Optional{});
    v("wrong_fix_s", wrong_fix_s, config::Range{0.1, 1000.0}, config::Optional{});
    v("fix_age_s", fix_age_s, config::Range{0.1, 1000.0}, config::Optional{});
    v("max_age_s", max_age_s, config::Range{0.1, 1000.0}, config::Optional{});
    v("phase_multipath_m", phase_multipath_m, config::Range{0.0, 1.0}, config::Optional{});
    v("code_multipath_m", code_multipath_m, config::Range{0.0, 50.0}, config::Optional{});
    v("multipath_length_m", multipath_length_m, config::Range{0.05, 100.0}, config::Optional{});
    v("velocity_white_mps", velocity_white_mps, config::Range{0.0, 5.0}, config::Optional{});
    v("claimed_factor", claimed_factor, config::Range{0.1, 10.0}, config::Optional{});
    v("geoid_m", geoid_m, config::Range{-150.0, 150.0}, config::Optional{});
    v("events", events, config::Optional{});
    v.Require(max_age_s >= fix_age_s, "max_age_s", "at least fix_age_s");
  }
};

}  // namespace kawara::sim
