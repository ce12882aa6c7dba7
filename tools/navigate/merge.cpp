#include "tools/navigate/merge.hpp"

namespace kawara::navigate {

core::Expected<void> Merge(ImuFile& imu, const std::vector<Aid>& aids, const SampleSink& sink,
                           const std::function<void(const ImuFile&)>& progress) {
  auto next = aids.begin();
  for (;;) {
    const auto sample = imu.Next();
    if (!sample) return tl::unexpected(sample.error());
    if (!*sample) return {};
    for (; next != aids.end() && next->given <= (*sample)->time; ++next) sink.aid(*next);
    if (auto ok = sink.imu(**sample); !ok) return ok;
    progress(imu);
  }
}

}  // namespace kawara::navigate
