#include "tools/calibrate/board_run.hpp"

#include <charconv>
#include <filesystem>

#include "tools/calibrate/board_pictures.hpp"
#include "tools/calibrate/calibration_page.hpp"
#include "tools/calibrate/camera_file.hpp"
#include "tools/navigate/safe_file.hpp"

namespace kawara::calibrate {
namespace {

using core::ErrorCode;
using core::Fail;
using vision::CalibrationModel;

constexpr int kLeastSide = 3, kMostSide = 100;

core::Expected<vision::Board> BoardOf(const BoardOptions& options) {
  vision::Board board;
  board.square_m = options.square_m;
  const std::string& text = options.board;
  const char* const end = text.data() + text.size();
  const auto cols = std::from_chars(text.data(), end, board.cols);
  const bool has_rows = cols.ec == std::errc{} && cols.ptr != end && *cols.ptr == 'x';
  const auto rows = has_rows ? std::from_chars(cols.ptr + 1, end, board.rows) : cols;
  if (!has_rows || rows.ec != std::errc{} || rows.ptr != end || board.cols < kLeastSide ||
      board.rows < kLeastSide || board.cols > kMostSide || board.rows > kMostSide ||
      board.corners() < 12) {
    return Fail(ErrorCode::kInvalidArgument,
                "--board " + text +
                    ": expected COLSxROWS inner corners, 4x3 or more, as 9x6 for a board of 10 x 7 "
                    "squares");
  }
  return board;
}

/// Empty: auto.
core::Expected<std::optional<CalibrationModel>> ModelOf(const std::string& name) {
  std::string all = "auto";
  if (name == all) return std::optional<CalibrationModel>();
  for (const auto& known : ConfigNames(CalibrationModel{})) {
    if (known.name == name) return std::optional(known.value);
    all += std::string(", ") + known.name;
  }
  return Fail(ErrorCode::kInvalidArgument, "--model " + name + ": expected one of " + all);
}

core::Expected<vision::OpticalAxis> AxisOf(const std::string& name,
                                           std::optional<CalibrationModel> model) {
  if (name.empty()) {
    const bool ring =
        model == CalibrationModel::kDoughnut || model == CalibrationModel::kDoughnutCorrected;
    return ring ? vision::OpticalAxis::kUp : vision::OpticalAxis::kForward;
  }
  for (const auto& known : ConfigNames(vision::OpticalAxis{})) {
    if (known.name == name) return known.value;
  }
  return Fail(ErrorCode::kInvalidArgument, "--axis " + name + ": expected forward, up or down");
}

core::Expected<vision::CameraCalibration> Calibrate(const vision::Calibrator& calibrator,
                                                    std::optional<CalibrationModel> model) {
  if (model) return calibrator.Calibrate(*model);
  auto all = calibrator.CalibrateAll();
  if (!all) return tl::unexpected(all.error());
  return std::move(all->front());
}

core::Expected<void> WriteFile(const std::string& path, const std::string& text) {
  auto file = navigate::SafeFile::Create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->Write(text); !written) return written;
  return file->Commit();
}

}  // namespace

core::Expected<BoardResult> RunBoard(const BoardOptions& options,
                                     const std::function<void(const std::string&)>& say) {
  const auto board = BoardOf(options);
  if (!board) return tl::unexpected(board.error());
  const auto model = ModelOf(options.model);
  if (!model) return tl::unexpected(model.error());
  const auto axis = AxisOf(options.axis, *model);
  if (!axis) return tl::unexpected(axis.error());
  // Places that cannot be written are told before the work.
  for (const std::string& path : {options.out, options.report}) {
    if (path.empty()) continue;
    if (auto file = navigate::SafeFile::Create(path); !file) return tl::unexpected(file.error());
  }
  auto found = FindBoards(options.folder, *board);
  if (!found) return tl::unexpected(found.error());
  for (const std::string& warning : found->warnings) say("warning: " + warning);

  vision::CalibrationOptions calibration;
  calibration.picture = {found->width_px, found->height_px, options.mirrored, *axis};
  calibration.square_m = board->square_m;
  calibration.inner_px = options.inner_px;
  calibration.outer_px = options.outer_px;
  calibration.rim_px =
      found->brightest.RimPx({0.5 * (found->width_px - 1), 0.5 * (found->height_px - 1)});
  const auto calibrator = vision::Calibrator::Create(calibration, found->views);
  const auto in_folder = [&](const core::Error& error) {
    return Fail(ErrorCode::kFormat, options.folder + ": " + error.message);
  };
  if (!calibrator) return in_folder(calibrator.error());
  auto camera = Calibrate(*calibrator, *model);
  if (!camera) return in_folder(camera.error());
  for (const std::string& warning : camera->warnings) say("warning: " + warning);

  const std::string origin = std::to_string(found->views.size()) + " pictures of a " +
                             options.board + " board in " + options.folder;
  if (auto done = WriteFile(options.out, CameraFileOf(*camera, origin)); !done) {
    return tl::unexpected(done.error());
  }
  if (!options.report.empty()) {
    if (auto done = WriteFile(options.report, CalibrationPage(*camera, *found, origin)); !done) {
      return tl::unexpected(done.error());
    }
  }
  return BoardResult{std::move(*camera), found->pictures, found->views.size(), found->corners};
}

}  // namespace kawara::calibrate
