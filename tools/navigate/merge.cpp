#include "tools/navigate/merge.hpp"

namespace kawara::navigate {

core::Expected<void> Merge(const NextImu& next_imu, const std::vector<Aid>& aids,
                           const SampleSink& sink) {
  auto aid = aids.begin();
  for (;;) {
    const auto sample = next_imu();
    if (!sample) return tl::unexpected(sample.error());
    if (!*sample) return {};
    for (; aid != aids.end() && aid->given <= (*sample)->time; ++aid) sink.aid(*aid);
    if (auto ok = sink.imu(**sample); !ok) return ok;
  }
}

}  // namespace kawara::navigate
