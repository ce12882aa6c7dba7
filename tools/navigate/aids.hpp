#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/expected.hpp"
#include "core/measurements.hpp"
#include "estimation/nav_types.hpp"
#include "tools/navigate/sensor_files.hpp"

namespace kawara::navigate {

/// Anything that corrects the inertial navigation, and when it is handed over.
struct Aid {
  core::GpsTime given;  ///< the moment the navigator gets it
  std::variant<core::GnssFix, estimation::OdometrySample, estimation::AttitudeSample> data;
};

/// A GNSS position to compare the solution with.
struct Reference {
  enum class Role : std::uint8_t { kGiven, kHeldOut, kBlanked };
  core::GpsTime time;
  core::Geodetic antenna;
  core::RtkState rtk = core::RtkState::kNone;
  Role role = Role::kGiven;
  std::size_t window = 0;  ///< of kBlanked: which
};

/// What is to be kept from the filter; empty: nothing.
struct WithheldFiles {
  std::string blank;
  std::optional<int> blank_run;
  std::string hold_out;
};

/// The files around the inertial one, as the user named them; empty: not given.
struct AidFiles {
  std::string gnss;
  std::string odometry;
  std::string attitude;
  bool use_arrival_times = false;  ///< GNSS is handed over at t_rx instead of at its epoch
};

struct Aids {
  std::vector<Aid> given;             ///< ascending by `given`
  std::vector<Reference> references;  ///< every GNSS position of the file, ascending by epoch
  std::vector<TimeWindow> blanks;
  std::vector<CsvReport> reports;
};

/// `epochs` of the receiver, given when they were received, and `others`, without what is withheld:
/// blanked or held out (within a millisecond of an epoch listed), epochs are no aid any more, only
/// a reference. Errors: those of the files, and a hold-out file none of whose epochs is there.
core::Expected<Aids> MakeAids(const WithheldFiles& withheld, const std::vector<GnssRow>& epochs,
                              std::vector<Aid> others);

/// The same from CSV files. Errors: also those of the files.
core::Expected<Aids> ReadAids(const AidFiles& files, const WithheldFiles& withheld);

}  // namespace kawara::navigate
