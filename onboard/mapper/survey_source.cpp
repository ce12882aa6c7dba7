#include "onboard/mapper/survey_source.hpp"

#include <cstdio>

#include "comms/crc32c.hpp"

namespace kawara::mapper {

SurveySource::SurveySource(survey::Survey survey)
    : survey_(std::make_shared<const survey::Survey>(std::move(survey))),
      rig_{survey_->cameras, survey_->origin} {
  for (std::size_t i = 0; i < survey_->frames.size(); i = EndOfStop(i)) ++stops_;
}

std::size_t SurveySource::EndOfStop(std::size_t first) const {
  const auto& frames = survey_->frames;
  std::size_t end = first + 1;
  while (end < frames.size() &&
         frames[end].pose.map_from_body.isApprox(frames[first].pose.map_from_body, 1e-12)) {
    ++end;
  }
  return end;
}

core::Expected<std::optional<Stop>> SurveySource::Next() {
  const auto& frames = survey_->frames;
  if (next_frame_ >= frames.size()) return std::optional<Stop>();
  const std::size_t end = EndOfStop(next_frame_);
  const survey::PoseRow& row = frames[next_frame_].pose;
  Stop stop;
  stop.number = next_stop_++;
  stop.time = row.time;
  stop.map_from_body = row.map_from_body;
  if (row.has_covariance) stop.covariance = row.covariance;
  for (; next_frame_ < end; ++next_frame_) {
    const survey::SurveyFrame& frame = frames[next_frame_];
    const auto load = [survey = survey_, &frame]() -> core::Expected<SharedPicture> {
      auto picture = survey::LoadFrame(*survey, frame);
      if (!picture) return tl::unexpected(picture.error());
      return std::make_shared<const survey::Picture>(std::move(*picture));
    };
    stop.pictures.push_back(
        {static_cast<std::size_t>(frame.camera), survey::FullNameOf(*survey_, frame), load});
  }
  return stop;
}

std::string FingerprintOf(const std::filesystem::path& folder) {
  std::uint32_t crc = 0;
  for (const char* name : {"camera.yaml", "poses.csv", "poses.txt", "poses.tum"}) {
    const auto bytes = survey::ReadBytes(folder / name);
    if (bytes) crc = comms::Crc32c(*bytes, crc);
  }
  char text[16];
  std::snprintf(text, sizeof text, "%08x", crc);
  return text;
}

}  // namespace kawara::mapper
