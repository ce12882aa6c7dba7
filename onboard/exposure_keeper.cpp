#include "onboard/exposure_keeper.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kawara::onboard {
namespace {

/// The rule as the configuration's control can carry it out.
vision::AutoExposureConfig RuleFor(const ExposureSettings& settings) {
  vision::AutoExposureConfig rule = settings.rule;
  rule.exposure_step_s = settings.exposure_unit_s;
  if (settings.gain_control.empty()) rule.max_gain = 1.0;
  return rule;
}

/// In the middle of what is allowed, as light goes.
vision::ExposureSetting Begin(const vision::AutoExposureConfig& rule) {
  return {std::sqrt(rule.min_exposure_s * rule.max_exposure_s), 1.0};
}

vision::MeteringArea AreaOf(const vision::Phase1PictureConfig& picture) {
  if (picture.camera != "doughnut") return {};
  const vision::DoughnutParameters& ring = picture.doughnut;
  return {ring.center_u_px, ring.center_v_px, ring.l_in_px, ring.l_out_px};
}

}  // namespace

ExposureKeeper::ExposureKeeper(const ExposureSettings& settings,
                               const vision::Phase1PictureConfig& picture, core::Counters& counters,
                               Set set)
    : settings_(settings),
      control_(RuleFor(settings), Begin(settings.rule)),
      area_(AreaOf(picture)),
      area_width_px_(picture.doughnut.width_px),
      set_(std::move(set)),
      sets_(counters.Register("camera.exposure.set")),
      refused_(counters.Register("camera.exposure.refused")),
      unreadable_(counters.Register("camera.exposure.unreadable")),
      exposure_us_(counters.Register("camera.exposure.exposure_us")),
      gain_percent_(counters.Register("camera.exposure.gain_percent")) {}

void ExposureKeeper::OnFrame(const drivers::Frame& frame) {
  if (frame.arrival < next_) return;
  next_ = frame.arrival + core::DurationFromSeconds(settings_.period_s);
  if (!begun_) {  // whatever the camera had before: from here on the setting is ours
    begun_ = true;
    return Apply(control_.setting(), frame.arrival);
  }
  const auto light = Measure(frame);
  if (!light) return unreadable_.Add();
  if (const auto wanted = control_.Next(*light, frame.exposure_start)) {
    Apply(*wanted, frame.arrival);
  }
}

core::Expected<vision::LightHistogram> ExposureKeeper::Measure(const drivers::Frame& frame) {
  const int width_px = static_cast<int>(frame.width), height_px = static_cast<int>(frame.height);
  const double scale = area_.outer_px > 0.0 ? frame.width / area_width_px_ : 1.0;
  if (frame.format == drivers::PixelFormat::kGrey8) {
    return vision::MeasureGreyLight(frame.bytes.data(), width_px, height_px, area_.Scaled(scale));
  }
  if (frame.format == drivers::PixelFormat::kRgb8) {
    return vision::MeasureLight({frame.bytes.data(), width_px, height_px}, area_.Scaled(scale));
  }
  const auto small = decoder_.Decode(frame.bytes, {.scale_eighths = 1, .accept_damage = true});
  if (!small) return tl::unexpected(small.error());
  return vision::MeasureLight(*small, area_.Scaled(scale / 8.0));
}

void ExposureKeeper::Apply(const vision::ExposureSetting& wanted, core::MonoTime now) {
  const auto exposure = std::max(1L, std::lround(wanted.exposure_s / settings_.exposure_unit_s));
  core::config::NamedTexts controls{{settings_.exposure_control, std::to_string(exposure)}};
  vision::ExposureSetting real{static_cast<double>(exposure) * settings_.exposure_unit_s, 1.0};
  if (!settings_.gain_control.empty()) {
    const auto gain = std::lround(wanted.gain * settings_.gain_unity);
    controls.emplace_back(settings_.gain_control, std::to_string(gain));
    real.gain = static_cast<double>(gain) / settings_.gain_unity;
  }
  if (!set_(controls)) return refused_.Add();
  sets_.Add();
  control_.OnSet(real, now);
  exposure_us_.Set(std::lround(1e6 * real.exposure_s));
  gain_percent_.Set(std::lround(100.0 * real.gain));
}

}  // namespace kawara::onboard
