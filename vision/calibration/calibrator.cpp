#include "vision/calibration/calibrator.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <tuple>

#include "vision/calibration/first_guess.hpp"

namespace kawara::vision {
namespace {

using core::ErrorCode;
using core::Fail;

constexpr CalibrationModel kGuessed = CalibrationModel::kDoughnutCorrected;
constexpr std::size_t kLeastViews = 3, kGoodViews = 8;
constexpr std::size_t kFolds = 5;
/// A camera is not determined if it projects directions this many times worse than corners were
/// seen; its doubt is told beyond so many pixels.
constexpr double kMostDoubt = 20.0, kGoodDoubtPx = 0.5;
/// Boards whose normals differ by less are parallel [rad].
constexpr double kLeastTilt = 3.0 * core::kRadFromDeg;
/// What is seen of the picture's radius and cells, below which there is a warning.
constexpr double kGoodRadius = 0.7, kGoodCells = 0.5;
/// Residuals that say that the camera is none of the model [px].
constexpr double kPoorRms = 0.7;
/// The calibration is taken to hold this share of what boards covered beyond it.
constexpr double kMargin = 0.05;
/// Models whose cross validation differs by less are as good.
constexpr double kAsGood = 1.02;
/// A focal length is known if its deviation is a smaller part of it.
constexpr double kKnownFocal = 0.05;

template <class... Parts>
std::string Text(const Parts&... parts) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  (text << ... << parts);
  return text.str();
}

int Percent(double share) { return static_cast<int>(std::lround(100.0 * share)); }

/// The largest angle between two boards' normals, whichever side they show.
double Tilt(const BundleState& state) {
  double most = 0.0;
  for (const auto& a : state.optical_from_board) {
    for (const auto& b : state.optical_from_board) {
      const double cosine = std::abs(a.linear().col(2).dot(b.linear().col(2)));
      most = std::max(most, std::acos(std::min(1.0, cosine)));
    }
  }
  return most;
}

/// Mean distance of all corners, those left out as well: leaving out more is no better fit.
double MisfitOf(const BundleFit& fit) {
  double sum = 0.0;
  std::size_t corners = 0;
  for (const auto& view : fit.residuals) {
    for (const auto& residual : view) sum += residual.norm();
    corners += view.size();
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, corners));
}

double ProjectionSd(const BundleProblem& problem, const BundleFit& fit, const AngleRange& seen) {
  const Eigen::VectorXd& p = fit.state.parameters;
  const auto info = TrialCamera::ParametersOf(problem.model, problem.picture);
  double most = 0.0;
  std::vector<TrialCamera> beside;
  for (std::size_t k = 0; k < info.size(); ++k) {
    for (const double sign : {-1.0, 1.0}) {
      Eigen::VectorXd moved = p;
      moved[static_cast<Eigen::Index>(k)] += sign * info[k].step;
      beside.emplace_back(problem.model, problem.picture, moved);
    }
  }
  Eigen::MatrixXd J(2, p.size());
  for (int a = 0; a <= 8; ++a) {
    const double angle = seen.low_rad + (seen.high_rad - seen.low_rad) * a / 8.0;
    for (int i = 0; i < 8; ++i) {
      const double azimuth = core::kPi * i / 4.0;
      const Eigen::Vector3d ray(std::sin(angle) * std::cos(azimuth),
                                std::sin(angle) * std::sin(azimuth), std::cos(angle));
      for (std::size_t k = 0; k < info.size(); ++k) {
        J.col(static_cast<Eigen::Index>(k)) =
            (beside[2 * k + 1].Project(ray) - beside[2 * k].Project(ray)) / (2.0 * info[k].step);
      }
      const double variance = (J * fit.covariance * J.transpose()).trace();
      if (std::isfinite(variance)) most = std::max(most, variance);
    }
  }
  return std::sqrt(most);
}

/// The angle at which a camera's plane radius is `radius`, beside the angles seen.
double AngleOf(const TrialCamera& camera, double radius, double low_rad, double high_rad) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low_rad + high_rad);
    (camera.Radius(middle) < radius ? low_rad : high_rad) = middle;
  }
  return 0.5 * (low_rad + high_rad);
}

/// A focal length that nothing tells although directions are well known: of double sphere about
/// xi = 0, or of Mei where boards did not reach far out, others take its part.
bool MakeUpForEachOther(const CameraCalibration& made) {
  return std::ranges::any_of(made.numbers, [](const EstimatedNumber& number) {
    const bool focal = number.name == "fx_px" || number.name == "a0";
    return focal && number.sd > kKnownFocal * std::abs(number.value);
  });
}

}  // namespace

core::Expected<Calibrator> Calibrator::Create(const CalibrationOptions& options,
                                              std::vector<BoardView> views) {
  if (views.size() < kLeastViews) {
    return Fail(ErrorCode::kInvalidArgument,
                Text(views.size(), " pictures show the board: at least ", kLeastViews,
                     " are needed, 10 to 20 are good"));
  }
  Calibrator made(options, std::move(views));
  auto guess = GuessCamera(options.picture, options.square_m, made.views_);
  if (!guess) {
    return Fail(ErrorCode::kInvalidArgument,
                "no camera makes flat boards of these pictures: are they all of one camera, and "
                "not cropped or zoomed in between?");
  }
  made.guess_ = std::move(*guess);
  return made;
}

BundleProblem Calibrator::ProblemOf(CalibrationModel model) const {
  return {model, options_.picture, options_.square_m, &views_, {}};
}

// The same picture in another model's optical frame: turned about the axis, and reflected where the
// models' handedness differs, which a flat board does not mind.
std::vector<BundleState> Calibrator::StartsOf(CalibrationModel model) const {
  const BundleProblem guessed = ProblemOf(kGuessed);
  const AngleRange seen = SeenAngles(guessed, guess_);
  const TrialCamera from(kGuessed, options_.picture, guess_.parameters);
  std::vector<BundleState> starts;
  for (const Eigen::VectorXd& numbers :
       ConvertCamera(kGuessed, guess_.parameters, model, options_.picture, seen)) {
    const TrialCamera to(model, options_.picture, numbers);
    const Eigen::Matrix2d across = to.affine().inverse() * from.affine();
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(across, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = svd.matrixU() * svd.matrixV().transpose();
    BundleState start{numbers, {}};
    for (const Eigen::Isometry3d& pose : guess_.optical_from_board) {
      Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
      const Eigen::Vector3d x = turn * pose.linear().col(0), y = turn * pose.linear().col(1);
      turned.linear() << x, y, x.cross(y);
      turned.translation() = turn * pose.translation();
      start.optical_from_board.push_back(turned);
    }
    starts.push_back(std::move(start));
  }
  return starts;
}

core::Expected<CameraCalibration> Calibrator::Calibrate(CalibrationModel model) const {
  const auto cannot = [&](const std::string& why) {
    return Fail(ErrorCode::kInvalidArgument, "model " + NameOf(model) + ": " + why);
  };
  const auto starts = StartsOf(model);
  if (starts.empty()) return cannot("cannot see as far from its axis as these boards were");
  const BundleProblem problem = ProblemOf(model);
  CameraCalibration made;
  made.model = model;
  for (const BundleState& start : starts) {
    BundleFit fit = FitBundle(problem, start);
    if (fit.iterations == 0) continue;
    if (made.fit.iterations == 0 || MisfitOf(fit) < MisfitOf(made.fit)) made.fit = std::move(fit);
  }
  if (made.fit.iterations == 0) return cannot("does not explain these pictures");
  const double tilt = Tilt(made.fit.state);
  const Eigen::VectorXd& p = made.fit.state.parameters;
  const AngleRange corners = SeenAngles(problem, made.fit.state);
  made.projection_sd_px = ProjectionSd(problem, made.fit, corners);
  const TrialCamera camera(model, options_.picture, p);
  const double rim_px = options_.outer_px.value_or(options_.rim_px.value_or(
      0.5 * std::min(options_.picture.width_px, options_.picture.height_px)));
  made.coverage = CoverageOf(views_, camera.center_px(), rim_px);
  if (tilt < kLeastTilt) {
    return cannot(Text("all boards are parallel to ", tilt * core::kDegFromRad,
                       " deg: hold the board at different slants, 30 deg and more"));
  }
  if (!made.fit.determined || !(made.projection_sd_px < kMostDoubt * made.fit.sd_px)) {
    return cannot(
        Text("these boards do not determine it (its own doubt is ", made.projection_sd_px,
             " px; they cover ", Percent(made.coverage.CellShare()),
             " % of the picture's cells, their slants differ by ", tilt * core::kDegFromRad,
             " deg): take pictures with the board near the rim, all around, at different slants"));
  }
  const double margin = kMargin * (corners.high_rad - corners.low_rad);
  made.seen = {std::max(0.0, corners.low_rad - margin),
               std::min(core::kPi, corners.high_rad + margin)};
  const double focal_px = camera.affine().col(0).norm();
  if (options_.inner_px) {
    made.seen.low_rad = AngleOf(camera, *options_.inner_px / focal_px, 0.0, corners.high_rad);
  }
  if (options_.outer_px) {
    made.seen.high_rad = AngleOf(camera, *options_.outer_px / focal_px, corners.low_rad, core::kPi);
  }
  auto optics = ChoiceOf(model, options_.picture, p, made.seen);
  if (!optics) return cannot(optics.error().message);
  made.optics = std::move(*optics);
  const auto info = TrialCamera::ParametersOf(model, options_.picture);
  for (std::size_t i = 0; i < info.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    made.numbers.push_back(
        {info[i].name, p[k] * info[i].per_unit,
         std::sqrt(std::max(0.0, made.fit.covariance(k, k))) * info[i].per_unit});
  }
  made.cross_validated_px = CrossValidated(problem, made.fit);
  Judge(made);
  return made;
}

void Calibrator::Judge(CameraCalibration& made) const {
  std::size_t all = 0;
  for (const auto& view : made.fit.used) {
    all += view.size();
    made.left_out += static_cast<int>(std::ranges::count(view, false));
  }
  if (views_.size() < kGoodViews) {
    made.warnings.push_back(
        Text("only ", views_.size(), " pictures show the board: 10 to 20 are good"));
  }
  if (made.coverage.RadiusShare() < kGoodRadius) {
    made.warnings.push_back(Text("boards reach over ", Percent(made.coverage.RadiusShare()),
                                 " % of the radius only: bring some nearer to the rim"));
  }
  const std::string hours = made.coverage.EmptyHours();
  if (made.coverage.CellShare() < kGoodCells || !hours.empty()) {
    made.warnings.push_back(Text("boards cover ", Percent(made.coverage.CellShare()),
                                 " % of the picture's cells only",
                                 hours.empty() ? "" : ", half and more of it is empty at " + hours,
                                 ": put them all around, as near to the rim as to the middle"));
  }
  if (made.fit.rms_px > kPoorRms) {
    made.warnings.push_back(Text("residuals of ", made.fit.rms_px,
                                 " px rms: another model may fit better (--model auto), the board "
                                 "may be bent, the pictures blurred, or the mirror not central"));
  }
  if (made.projection_sd_px > kGoodDoubtPx) {
    made.warnings.push_back(Text("directions are projected to ", made.projection_sd_px,
                                 " px (1 sigma) at the worst: more pictures would help"));
  }
  if (MakeUpForEachOther(made)) {
    made.warnings.push_back(
        "the numbers of this model make up for each other (their deviations): together they give "
        "good directions, one by one they mean nothing; --model auto looks for one where they do");
  }
  if (made.left_out > 0.05 * static_cast<double>(all)) {
    made.warnings.push_back(
        Text(made.left_out, " of ", all, " corners contradict the rest and were left out"));
  }
}

double Calibrator::CrossValidated(const BundleProblem& problem, const BundleFit& fit) const {
  const std::size_t folds = std::min(kFolds, views_.size());
  double sum = 0.0, corners = 0.0;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<BoardView> rest;
    BundleState start{fit.state.parameters, {}};
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (v % folds == fold) continue;
      rest.push_back(views_[v]);
      start.optical_from_board.push_back(fit.state.optical_from_board[v]);
    }
    BundleProblem without = problem;
    without.views = &rest;
    const BundleFit other = FitBundle(without, start);
    for (std::size_t v = fold; v < views_.size(); v += folds) {
      const double rms =
          ViewRms(problem, other.state.parameters, views_[v], fit.state.optical_from_board[v]);
      if (!std::isfinite(rms)) return std::numeric_limits<double>::infinity();
      sum += rms * rms * static_cast<double>(views_[v].size());
      corners += static_cast<double>(views_[v].size());
    }
  }
  return std::sqrt(sum / corners);
}

core::Expected<std::vector<CameraCalibration>> Calibrator::CalibrateAll() const {
  std::vector<CameraCalibration> all;
  std::string why;
  for (const auto& name : ConfigNames(CalibrationModel{})) {
    const bool ring = name.value == CalibrationModel::kDoughnut ||
                      name.value == CalibrationModel::kDoughnutCorrected;
    if (ring && options_.picture.axis == OpticalAxis::kForward) continue;
    auto made = Calibrate(name.value);
    if (made) {
      all.push_back(std::move(*made));
    } else {
      why = made.error().message;
    }
  }
  if (all.empty()) return Fail(ErrorCode::kInvalidArgument, why);
  double best = std::numeric_limits<double>::infinity();
  for (const auto& made : all) best = std::min(best, made.cross_validated_px);
  const auto rank = [best](const CameraCalibration& made) {
    // As good as the best: those whose numbers mean something first, by their count. The others
    // behind, by what they miss.
    const bool good = made.cross_validated_px <= kAsGood * best;
    return std::tuple(good ? 0.0 : made.cross_validated_px, good && MakeUpForEachOther(made),
                      good ? made.numbers.size() : 0);
  };
  std::ranges::stable_sort(all, std::ranges::less(), rank);
  return all;
}

}  // namespace kawara::vision
