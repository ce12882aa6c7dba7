#include "drivers/v4l2_mode_choice.hpp"

#include <cmath>
#include <cstdio>
#include <optional>
#include <tuple>

namespace kawara::drivers {
namespace {

/// 29.97 is 30 to everybody who writes a configuration.
constexpr double kRateTolerance = 0.995;

bool Reaches(const V4l2Interval& interval, double rate_hz) {
  return interval.rate_hz() >= kRateTolerance * rate_hz;
}

/// The slowest interval that reaches the rate; "unknown" where the device does not tell.
std::optional<V4l2Interval> IntervalFor(const V4l2SizeOffer& size, double rate_hz) {
  if (size.intervals.empty()) return V4l2Interval{};
  std::optional<V4l2Interval> best;
  for (const V4l2Interval& interval : size.intervals) {
    if (!Reaches(interval, rate_hz)) continue;
    if (!best || interval.rate_hz() < best->rate_hz()) best = interval;
  }
  if (best && size.any_rate_between && rate_hz > size.intervals.back().rate_hz()) {
    return V4l2Interval{1000, static_cast<std::uint32_t>(std::lround(rate_hz * 1000.0))};
  }
  return best;
}

std::string TextOf(const V4l2ModeWish& wish) {
  std::string text = wish.format.empty() ? "any of " + V4l2PixelFormatNames() : wish.format;
  if (wish.width_px != 0) {
    text += ", " + std::to_string(wish.width_px) + "x" + std::to_string(wish.height_px);
  }
  char rate[32];
  std::snprintf(rate, sizeof rate, ", at least %.4g Hz", wish.rate_hz);
  return text + rate;
}

}  // namespace

std::string TextOf(const V4l2Mode& mode) {
  std::string text = FourccText(mode.fourcc) + " " + std::to_string(mode.width_px) + "x" +
                     std::to_string(mode.height_px);
  if (!mode.interval.known()) return text;
  char rate[32];
  std::snprintf(rate, sizeof rate, " at %.4g Hz", mode.interval.rate_hz());
  return text + rate;
}

core::Expected<V4l2Mode> ChooseV4l2Mode(const std::vector<V4l2FormatOffer>& offers,
                                        const V4l2ModeWish& wish) {
  std::optional<V4l2Mode> best;
  using Merit = std::tuple<std::uint64_t, std::ptrdiff_t, double>;
  Merit best_merit;
  for (const V4l2FormatOffer& offer : offers) {
    const V4l2PixelFormat* const format = FindV4l2PixelFormat(offer.fourcc);
    if (format == nullptr || (!wish.format.empty() && wish.format != format->name)) continue;
    for (const V4l2SizeOffer& size : offer.sizes) {
      const bool wished = wish.width_px != 0;
      if (wished && !size.Has(wish.width_px, wish.height_px)) continue;
      const auto interval = IntervalFor(size, wish.rate_hz);
      if (!interval) continue;
      const V4l2Mode mode{offer.fourcc, wished ? wish.width_px : size.max_width,
                          wished ? wish.height_px : size.max_height, *interval};
      const Merit merit{std::uint64_t{mode.width_px} * mode.height_px,
                        V4l2PixelFormats().data() - format, -interval->rate_hz()};
      if (best && merit <= best_merit) continue;
      best = mode;
      best_merit = merit;
    }
  }
  if (best) return *best;
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "does not offer " + TextOf(wish) + "; it offers: " + TextOf(offers));
}

}  // namespace kawara::drivers
