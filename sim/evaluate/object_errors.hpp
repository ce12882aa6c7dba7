#pragma once
#include <string>
#include <utility>
#include <vector>

#include "sim/evaluate/error_statistics.hpp"
#include "sim/evaluate/upright_boxes.hpp"

namespace kawara::sim {

/// Which found box is which true one: pairs (index of truth, index of result), each box in one pair
/// at most. Best overlap first; boxes that do not overlap are paired by centres nearer than
/// `max_distance_m` in the plane, nearest first.
std::vector<std::pair<std::size_t, std::size_t>> MatchBoxes(const std::vector<ApexBox>& truth,
                                                            const std::vector<ApexBox>& result,
                                                            double max_distance_m = 2.0);

/// Found, missed and false objects; of the found ones errors of centre, size, heading, apexes, and
/// the overlap. Apexes are compared each with the nearest of the same level, since boxes may start
/// their apexes at another corner.
ErrorReport CompareObjects(const std::vector<ApexBox>& truth, const std::vector<ApexBox>& result,
                           double max_distance_m = 2.0);

/// One line a true or false object: "found truck-1 as 17: centre 0.08 m, overlap 0.71", "missed
/// car-2", "false 19 (car) at ...".
std::string ListObjects(const std::vector<ApexBox>& truth, const std::vector<ApexBox>& result,
                        double max_distance_m = 2.0);

}  // namespace kawara::sim
