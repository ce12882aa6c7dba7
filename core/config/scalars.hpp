#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/config/constraints.hpp"
#include "core/config/problems.hpp"
#include "core/config/tree.hpp"
#include "core/time.hpp"

/// Single values between the YAML tree and C++: what every field type comes down to. A value that
/// does not fit is reported as "path = value: expected ..." and leaves `out` alone.
namespace kawara::core::config {

void ReadBool(const Node& node, const std::string& path, bool& out, Problems& problems);
/// Decimal or 0x hexadecimal, within [min, max] (the C++ type's) and the constraints.
void ReadInteger(const Node& node, const std::string& path, const Constraints& constraints,
                 std::int64_t min, std::int64_t max, std::int64_t& out, Problems& problems);
/// Finite decimal number.
void ReadDouble(const Node& node, const std::string& path, const Constraints& constraints,
                double& out, Problems& problems);
void ReadString(const Node& node, const std::string& path, const Constraints& constraints,
                std::string& out, Problems& problems);
/// A section of any keys, each with a single value.
void ReadNamedTexts(const Node& node, const std::string& path, NamedTexts& out, Problems& problems);
/// A number in the unit that ends the key: _ns _us _ms _s _min _h.
void ReadDuration(const Node& node, const std::string& path, const Constraints& constraints,
                  Duration& out, Problems& problems);
/// Index into `names`.
void ReadEnum(const Node& node, const std::string& path, const std::vector<const char*>& names,
              std::size_t& out, Problems& problems);

/// What a field expects, for people: "a whole number 20..20000".
std::string ExpectedBool();
std::string ExpectedInteger(const Constraints& constraints, std::int64_t min, std::int64_t max);
std::string ExpectedDouble(const Constraints& constraints);
std::string ExpectedString(const Constraints& constraints);
std::string ExpectedNamedTexts();
std::string ExpectedDuration(const std::string& path, const Constraints& constraints);
std::string ExpectedEnum(const std::vector<const char*>& names);

/// Texts that read back to the same value.
std::string TextOfDouble(double value);
std::string TextOfString(const std::string& value);
std::string TextOfDuration(Duration value, const std::string& path);

/// How many nanoseconds the unit is that ends this key. A key of a Duration without a unit is our
/// bug.
std::int64_t NanosecondsPerUnit(const std::string& path);

}  // namespace kawara::core::config
