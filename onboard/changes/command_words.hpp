#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"

namespace kawara::changes {

// Words of the command lines of kawara-changes and kawara-reference. Errors: kInvalidArgument.

/// "35.3606,139.5310,52.0": latitude, longitude [deg], ellipsoidal height [m]; or the folder of a
/// model of kawara-mapper: its map's.
core::Expected<core::Geodetic> ParseOrigin(const std::string& word);
/// "2.5,3,4": numbers.
core::Expected<std::vector<double>> ParseNumbers(const std::string& word);
/// ISO 8601, with or without the time of day.
core::Expected<core::UtcTime> ParseTime(const std::string& word);
/// The same; empty: when the file was last written.
core::Expected<core::UtcTime> TimeOr(const std::string& word, const std::string& file);

/// One line "PROGRAM: message" on standard error; gives `status` back.
int Fail(const std::string& message, int status);
/// The same with the status of an error: 2 for what the user can mend in the command, else 1.
int Fail(const core::Error& error);

}  // namespace kawara::changes
