#pragma once
#include <string>

#include "core/config/constraints.hpp"

/// Schema of configs/station.yaml: defaults, units in the keys, ranges. The command line wins over
/// the file.
namespace kawara::station {

namespace config = core::config;

struct StoreSettings {
  std::string target = "store.gpkg";  ///< GeoPackage file, or "PG:dbname=..." for PostGIS
  std::string pictures_dir;           ///< empty: "pictures" beside the store

  template <class V>
  void Visit(V& v) {
    v("target", target, config::NotEmpty{}, config::Optional{});
    v("pictures_dir", pictures_dir, config::Optional{});
  }
};

struct StationConfig {
  std::string lcm_url;  ///< empty: LCM's default group on this machine
  StoreSettings store;
  double pose_rate_hz = 1.0;  ///< periodic poses kept besides that of every exposure
  double max_picture_mb = 32.0;
  double queue_mb = 256.0;       ///< what may wait in memory while the store cannot be written
  double commit_period_s = 0.2;  ///< poses and events wait this long at most; pictures do not wait
  double retry_period_s = 0.5;   ///< between attempts while the store cannot be written
  double give_up_s = 10.0;       ///< at the end: how long to go on trying

  template <class V>
  void Visit(V& v) {
    v("lcm_url", lcm_url, config::Optional{});
    v("store", store, config::Optional{});
    v("pose_rate_hz", pose_rate_hz, config::Range{0.0, 1000.0}, config::Optional{});
    v("max_picture_mb", max_picture_mb, config::Range{0.1, 64.0}, config::Optional{});
    v("queue_mb", queue_mb, config::Range{1.0, 65536.0}, config::Optional{});
    v("commit_period_s", commit_period_s, config::Range{0.0, 60.0}, config::Optional{});
    v("retry_period_s", retry_period_s, config::Range{0.01, 60.0}, config::Optional{});
    v("give_up_s", give_up_s, config::Range{0.0, 3600.0}, config::Optional{});
  }
};

}  // namespace kawara::station
