#pragma once
#include <cstddef>
#include <functional>
#include <optional>

#include "estimation/filter_tape.hpp"
#include "estimation/nav_types.hpp"

namespace kawara::estimation {

/// Runs back over the tape and hands out the smoothed solution of every node, NEWEST first. At the
/// newest node it equals the filter's. Modified Bryson-Frazier form of the fixed-interval
/// (Rauch-Tung-Striebel) smoother: no inverse of a covariance, so states that are known exactly do
/// no harm. Source: Bierman, Factorization Methods for Discrete Sequential Estimation (1977), ch.
/// X. `on_node` returns false to stop there. Allocates nothing. One thread.
void Smooth(const FilterTape& tape, const std::function<bool(const NavSolution&)>& on_node);

/// Fixed lag: the smoothed solution at `t`, with everything the tape holds after it, between the
/// nodes about it. Nothing if the tape does not reach back to `t` or ends before it.
std::optional<NavSolution> SmoothedAt(const FilterTape& tape, core::GpsTime t);

}  // namespace kawara::estimation
