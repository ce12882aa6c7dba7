#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "tools/navigate/aids.hpp"
#include "tools/navigate/navigation_run.hpp"
#include "tools/navigate/sensor_files.hpp"

namespace kawara::navigate {

/// Where merged samples go: an inertial sample may fail to be written.
struct SampleSink {
  std::function<core::Expected<void>(const estimation::ImuSample&)> imu;
  std::function<void(const Aid&)> aid;
};

/// The inertial samples in the order of the file, and before each of them every aid that has been
/// given by then (at the sample's stamp or earlier). Aids behind the last sample never come.
/// `progress` is told the share of the file that has been read. Errors: those of the file and of
/// the sink.
core::Expected<void> Merge(ImuFile& imu, const std::vector<Aid>& aids, const SampleSink& sink,
                           const std::function<void(const ImuFile&)>& progress);

}  // namespace kawara::navigate
