#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "core/expected.hpp"
#include "tools/navigate/aids.hpp"

namespace kawara::navigate {

/// Where inertial samples come from; nothing at the end.
using NextImu = std::function<core::Expected<std::optional<estimation::ImuSample>>()>;

/// Where merged samples go: an inertial sample may fail to be written.
struct SampleSink {
  std::function<core::Expected<void>(const estimation::ImuSample&)> imu;
  std::function<void(const Aid&)> aid;
};

/// The inertial samples in the order they come, and before each of them every aid that has been
/// given by then (at the sample's stamp or earlier). Aids behind the last sample never come.
/// Errors: those of the source and of the sink.
core::Expected<void> Merge(const NextImu& next_imu, const std::vector<Aid>& aids,
                           const SampleSink& sink);

}  // namespace kawara::navigate
