#pragma once
#include <filesystem>
#include <string>

#include "onboard/mapper/frame_source.hpp"

namespace kawara::mapper {

/// A survey folder, from its first pose to its last.
class SurveySource : public FrameSource {
 public:
  explicit SurveySource(survey::Survey survey);
  const Rig& rig() const override { return rig_; }
  core::Expected<std::optional<Stop>> Next() override;
  std::uint64_t total() const override { return stops_; }

 private:
  /// One past the last frame of the moment that `first` is of.
  std::size_t EndOfStop(std::size_t first) const;

  std::shared_ptr<const survey::Survey> survey_;
  Rig rig_;
  std::size_t next_frame_ = 0;
  std::uint64_t next_stop_ = 0, stops_ = 0;
};

/// Eight hex digits that change with the survey's camera.yaml and poses.
std::string FingerprintOf(const std::filesystem::path& folder);

}  // namespace kawara::mapper
