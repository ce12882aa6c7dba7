#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "onboard/mapper/frame_source.hpp"
#include "onboard/mapper/model_run.hpp"
#include "onboard/mapper/report/evenly_spread.hpp"
#include "onboard/mapper/report/report_page.hpp"

namespace kawara::mapper {

/// `--report`: gathers what there is to say while a model is made, and puts it on one page of HTML
/// at the end. The memory does not grow with the drive: a few frames are kept as samples, and the
/// model is drawn from its files, tile by tile. One thread.
class ModelReport {
 public:
  /// `truth`: a survey folder whose range/, if it has one, tells the true ranges
  /// (truth_ranges.hpp); empty: there is none. Errors, before any work is done: those of
  /// gis::CheckWritable for `page`.
  static core::Expected<ModelReport> Open(const std::filesystem::path& page,
                                          const std::filesystem::path& truth);

  /// For ModelHooks: a distance image, and a line for people, of which warnings are kept.
  void Measured(const PicturePair& pair, const vision::StereoCamera& camera,
                const vision::RangeImage& ranges);
  void Say(const std::string& line);

  /// Writes the page, whole or not at all. `source_name`: where the pictures came from. Errors: of
  /// reading the model's tiles, and of the page's file.
  core::Expected<void> Write(const ModelOptions& options, const ModelResult& result, const Rig& rig,
                             const std::string& source_name) const;

 private:
  struct Sample {
    std::uint64_t stop = 0;
    std::size_t camera = 0;
    ReportSample shown;
  };

  ModelReport(std::filesystem::path page, std::filesystem::path truth)
      : page_(std::move(page)), truth_(std::move(truth)) {}
  void Compare(const PicturePair& pair, const vision::RangeImage& ranges,
               const std::vector<std::uint8_t>& counted);
  std::vector<ReportRow> Figures(const ModelResult& result) const;
  std::vector<ReportSample> Samples() const;
  std::vector<ReportLink> Links(const std::filesystem::path& model) const;

  std::filesystem::path page_, truth_;
  std::vector<std::string> warnings_;
  std::optional<Accuracy> accuracy_;           ///< empty: no frame's truth was found
  std::vector<EvenlySpread<Sample>> samples_;  ///< one for each camera
  std::uint64_t pairs_ = 0, seen_px_ = 0, known_px_ = 0;
  double baselines_m_ = 0.0, way_m_ = 0.0;
  std::optional<Eigen::Vector3d> last_place_;  ///< of the first camera
  core::GpsTime first_time_;
};

}  // namespace kawara::mapper
