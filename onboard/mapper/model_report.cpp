#include "onboard/mapper/model_report.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "gis/model/ply_reader.hpp"
#include "gis/model/whole_file.hpp"
#include "onboard/mapper/report/model_view.hpp"
#include "onboard/mapper/report/report_picture.hpp"
#include "onboard/mapper/report/truth_ranges.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;

/// Distance images on the page, of all cameras together unless they are many.
constexpr std::size_t kMostSamples = 8;
constexpr const char* kWarning = "warning: ";

std::string Number(double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

double PeakMemoryMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e6;
}

/// Pixels that the camera sees with, 1 a byte.
std::vector<std::uint8_t> SeenBy(const vision::StereoCamera& camera, std::size_t pixels) {
  std::vector<std::uint8_t> seen(pixels);
  for (std::size_t i = 0; i < pixels; ++i) seen[i] = camera.rays().seen(i) ? 1 : 0;
  return seen;
}

float MedianM(const vision::RangeImage& ranges) {
  std::vector<float> known;
  for (const float range : ranges.range_m) {
    if (!std::isnan(range)) known.push_back(range);
  }
  if (known.empty()) return vision::RangeImage::kUnknown;
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  return *middle;
}

std::vector<ReportRow> OptionRows(const ModelOptions& options) {
  const StereoOptions& stereo = options.builder.stereo;
  const bool fast = stereo.method == StereoMethod::kFast;
  std::vector<ReportRow> rows{
      {"method", fast ? "fast" : "paper", ""},
      {"poses", options.pairs.refine ? "refined on the pictures" : "as given", ""},
      {"baselines", options.pairs.several ? "several" : "one", ""},
      {"baseline, at least about", Number(options.pairs.baseline_m, 2), "m"},
      {"step, at least about", Number(options.pairs.step_m, 2), "m"},
      {"nearest range", Number(stereo.nearest_m, 2), "m"},
      {"ranges voted up to", Number(options.builder.reach_m, 1), "m"},
      {"voxel", Number(options.builder.voxel_m, 2), "m"}};
  if (stereo.px_per_rad > 0.0) {
    rows.push_back({"search", Number(stereo.px_per_rad, 0), "px/rad"});
  }
  return rows;
}

/// Of the tiles that model.yaml in the folder lists.
core::Expected<std::vector<ReportPicture>> ViewsOf(const fs::path& model, double voxel_m) {
  const auto manifest = core::config::Load<ModelManifest>((model / "model.yaml").string());
  if (!manifest) return tl::unexpected(manifest.error());
  return DrawModelViews(
      [&](const TakePoints& take) -> core::Expected<void> {
        for (const TileRecord& tile : manifest->tiles) {
          if (tile.faces == 0) continue;
          const auto points = gis::ReadPlyPoints(model / (tile.name + ".ply"));
          if (!points) return tl::unexpected(points.error());
          take(*points);
        }
        return {};
      },
      voxel_m);
}

}  // namespace

core::Expected<ModelReport> ModelReport::Open(const fs::path& page, const fs::path& truth) {
  if (auto writable = gis::CheckWritable(page); !writable) {
    return core::Fail(writable.error().code, "--report: " + writable.error().message);
  }
  return ModelReport(page, truth);
}

void ModelReport::Say(const std::string& line) {
  if (line.starts_with(kWarning)) warnings_.push_back(line.substr(std::string(kWarning).size()));
}

void ModelReport::Measured(const PicturePair& pair, const vision::StereoCamera& camera,
                           const vision::RangeImage& ranges) {
  const Eigen::Vector3d here = pair.map_from_a.translation();
  if (pairs_++ == 0) first_time_ = pair.time;
  baselines_m_ += (pair.map_from_b.translation() - here).norm();
  if (pair.camera == 0) {
    if (last_place_) way_m_ += (here - *last_place_).norm();
    last_place_ = here;
  }
  const std::vector<std::uint8_t> seen = SeenBy(camera, ranges.range_m.size());
  const auto seen_px = static_cast<std::uint64_t>(std::ranges::count(seen, 1));
  const auto known_px = static_cast<std::uint64_t>(
      std::ranges::count_if(ranges.range_m, [](float range) { return !std::isnan(range); }));
  seen_px_ += seen_px;
  known_px_ += known_px;
  Compare(pair, ranges, seen);
  while (samples_.size() <= pair.camera) {
    samples_.emplace_back(kMostSamples);
  }
  samples_[pair.camera].Offer([&] {
    const double share = static_cast<double>(known_px) / static_cast<double>(seen_px);
    std::string caption = Number(100.0 * share, 1) + " % of what the camera sees has a range";
    if (known_px > 0) {
      caption += "; median " + Number(static_cast<double>(MedianM(ranges)), 2) + " m";
    }
    return Sample{pair.stop,
                  pair.camera,
                  {.frame = pair.name,
                   .picture = PhotoForReport(pair.picture_a->view(), "The picture"),
                   .ranges = RangesForReport(ranges, std::move(caption))}};
  });
}

void ModelReport::Compare(const PicturePair& pair, const vision::RangeImage& ranges,
                          const std::vector<std::uint8_t>& counted) {
  if (truth_.empty()) return;
  const auto truth = LoadTruth(truth_, pair.name, ranges.width_px, ranges.height_px);
  if (!truth) {
    // One is enough: the next frames' would most likely be as wrong.
    warnings_.push_back("true ranges were not compared with any more: " + truth.error().message);
    truth_.clear();
    return;
  }
  if (truth->empty()) return;
  if (!accuracy_) accuracy_.emplace();
  accuracy_->Add(ranges, *truth, counted);
}

std::vector<ReportRow> ModelReport::Figures(const ModelResult& result) const {
  std::vector<ReportRow> rows{{"pairs in the model", std::to_string(result.pairs), ""}};
  if (pairs_ != result.pairs) {
    rows.push_back({"pairs measured in this run", std::to_string(pairs_), ""});
  }
  rows.push_back({"time", Number(result.seconds, 1), "s"});
  if (pairs_ > 0) {
    const auto pairs = static_cast<double>(pairs_);
    rows.push_back({"rate", Number(pairs / std::max(1e-3, result.seconds), 2), "pairs/s"});
    rows.push_back({"way", Number(way_m_, 1), "m"});
    rows.push_back({"baseline, mean", Number(baselines_m_ / pairs, 3), "m"});
    const double seen = static_cast<double>(std::max<std::uint64_t>(1, seen_px_));
    rows.push_back(
        {"pixels with a range", Number(100.0 * static_cast<double>(known_px_) / seen, 1), "%"});
  }
  rows.push_back({"tiles", std::to_string(result.tiles), ""});
  rows.push_back({"faces", std::to_string(result.faces), ""});
  if (!result.rig.empty()) rows.push_back({"learnt of the rig", result.rig, ""});
  rows.push_back({"most memory", Number(PeakMemoryMb(), 0), "MB"});
  return rows;
}

std::vector<ReportSample> ModelReport::Samples() const {
  // Of each camera, so that all are to be seen.
  std::vector<const Sample*> all;
  for (const auto& of_camera : samples_) {
    const auto& kept = of_camera.kept();
    const std::size_t share = std::max<std::size_t>(2, kMostSamples / samples_.size());
    const std::size_t step = (kept.size() + share - 1) / share;
    for (std::size_t i = 0; i < kept.size(); i += step) all.push_back(&kept[i]);
  }
  std::ranges::stable_sort(all, {}, [](const Sample* s) { return std::pair(s->stop, s->camera); });
  std::vector<ReportSample> shown;
  shown.reserve(all.size());
  for (const Sample* sample : all) shown.push_back(sample->shown);
  return shown;
}

std::vector<ReportLink> ModelReport::Links(const fs::path& model) const {
  struct File {
    const char *name, *what;
  };
  constexpr std::array<File, 3> kFiles{
      {{"model.wrl", "the whole model, VRML97"},
       {"tileset.json", "the same as 3D Tiles"},
       {"model.yaml", "the tiles, each also as GLB, PLY and LAS"}}};
  std::error_code error;
  const fs::path base = fs::weakly_canonical(page_, error).parent_path();
  std::vector<ReportLink> links;
  for (const File& file : kFiles) {
    if (!fs::exists(model / file.name, error)) continue;
    const fs::path from_page = fs::relative(model / file.name, base, error);
    if (!error && !from_page.empty()) links.push_back({from_page.generic_string(), file.what});
  }
  return links;
}

core::Expected<void> ModelReport::Write(const ModelOptions& options, const ModelResult& result,
                                        const Rig& rig, const std::string& source_name) const {
  MapperReport report;
  report.title = "The model of a drive";
  report.survey = source_name;
  // A map of its own may have clocks of its own.
  if (rig.origin && first_time_.IsSet()) report.when = core::ToUtc(first_time_);
  report.warnings = warnings_;
  report.figures = Figures(result);
  report.options = OptionRows(options);
  report.accuracy = accuracy_;
  if (accuracy_) report.accuracy_against = kAgainstRenderedTruth;
  report.samples = Samples();
  auto views = ViewsOf(options.out, options.builder.voxel_m);
  if (!views) return tl::unexpected(views.error());
  report.views = std::move(*views);
  report.links = Links(options.out);
  return gis::WriteWholeFile(page_, MapperReportPage(report));
}

}  // namespace kawara::mapper
