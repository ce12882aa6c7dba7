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

/// The files around the inertial one, as the user named them; empty: not given.
struct AidFiles {
  std::string gnss;
  std::string odometry;
  std::string attitude;
  std::string blank;
  std::optional<int> blank_run;
  std::string hold_out;
  bool use_arrival_times = false;  ///< GNSS is handed over at t_rx instead of at its epoch
};

struct Aids {
  std::vector<Aid> given;             ///< ascending by `given`
  std::vector<Reference> references;  ///< every GNSS position of the file, ascending by epoch
  std::vector<TimeWindow> blanks;
  std::vector<CsvReport> reports;
};

/// Reads all of them. What is blanked or held out (epochs within a millisecond of those listed) is
/// no aid any more, only a reference. Errors: those of the files, and a hold-out file none of whose
/// epochs is in the GNSS file.
core::Expected<Aids> ReadAids(const AidFiles& files);

}  // namespace kawara::navigate
