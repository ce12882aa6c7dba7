#include "sim/survey.hpp"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "sim/camera/camera_file.hpp"
#include "sim/dice.hpp"
#include "sim/render/frame_files.hpp"
#include "sim/run/truth_recorder.hpp"
#include "sim/world/world_truth.hpp"

namespace kawara::sim {
namespace {

namespace fs = std::filesystem;

/// Instants at which the vehicle has gone another `every_m`; the first is the start.
std::vector<core::GpsTime> Exposures(const SiteWorld& world, const SurveyOptions& options) {
  const Trajectory& motion = world.trajectory();
  const core::GpsTime begin = motion.begin() + core::DurationFromSeconds(options.start_s);
  const core::GpsTime end =
      options.duration_s ? begin + core::DurationFromSeconds(*options.duration_s) : motion.end();
  std::vector<core::GpsTime> instants;
  double gone_m = 0.0, next_m = 0.0;
  Eigen::Vector3d last = motion.At(begin).position_enu_m;
  for (core::GpsTime t = begin; t <= std::min(end, motion.end()); t += core::Milliseconds(10)) {
    const Eigen::Vector3d here = motion.At(t).position_enu_m;
    gone_m += (here - last).norm();
    last = here;
    if (gone_m < next_m) continue;
    instants.push_back(t);
    next_m += options.every_m;
  }
  return instants;
}

struct CameraPose {
  core::Geodetic place;
  core::Attitude attitude;  ///< the body's
};

CameraPose PoseAt(const SiteWorld& world, core::GpsTime t) {
  const Trajectory& motion = world.trajectory();
  return {motion.GeodeticAt(t, world.robot().vehicle.camera_frd_m), motion.AttitudeAt(t)};
}

CameraPose WithNoise(const CameraPose& pose, const SurveyOptions& options, Dice& dice) {
  const auto three = [&dice](double sd) {
    const double a = sd * dice.Normal(), b = sd * dice.Normal(), c = sd * dice.Normal();
    return Eigen::Vector3d(a, b, c);
  };
  const Eigen::Vector3d ned_m = three(options.pose_noise_m);
  const Eigen::Vector3d turn_rad = three(options.attitude_noise_deg * core::kRadFromDeg);
  return {core::OffsetNed(pose.place, ned_m),
          {pose.attitude.roll_rad + turn_rad.x(), pose.attitude.pitch_rad + turn_rad.y(),
           core::WrapPi(pose.attitude.yaw_rad + turn_rad.z())}};
}

/// One of the two tables of poses.
class PoseTable {
 public:
  explicit PoseTable(fs::path path)
      : path_(std::move(path)), file_(std::fopen(path_.c_str(), "w"), std::fclose) {
    if (!file_) return;
    std::fputs(
        "frame,gps_ns,lat_deg,lon_deg,h_ellipsoidal_m,roll_deg,pitch_deg,yaw_deg,sd_east_m,"
        "sd_north_m,sd_up_m,sd_attitude_deg\n",
        file_.get());
  }
  core::Expected<void> Add(int frame, core::GpsTime t, const CameraPose& pose, double sd_m,
                           double sd_deg) {
    if (file_) {
      std::fprintf(file_.get(), "%05d,%lld,%.11f,%.11f,%.5f,%.6f,%.6f,%.6f,%g,%g,%g,%g\n", frame,
                   static_cast<long long>(t.ns()), pose.place.lat_rad * core::kDegFromRad,
                   pose.place.lon_rad * core::kDegFromRad, pose.place.h_ellipsoidal_m,
                   pose.attitude.roll_rad * core::kDegFromRad,
                   pose.attitude.pitch_rad * core::kDegFromRad,
                   pose.attitude.yaw_rad * core::kDegFromRad, sd_m, sd_m, sd_m, sd_deg);
      if (std::fflush(file_.get()) == 0) return {};
    }
    return tl::unexpected(core::ErrnoError("write " + path_.string(), errno));
  }

 private:
  fs::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

core::Expected<void> MakeFolders(const fs::path& folder) {
  for (const char* part : {"frames", "range", "object"}) {
    std::error_code error;
    fs::create_directories(folder / part, error);
    if (error) {
      return core::Fail(core::ErrorCode::kIo, (folder / part).string() + ": " + error.message());
    }
  }
  return {};
}

core::Expected<void> WriteFrame(const fs::path& folder, int number, const RenderedFrame& frame,
                                int jpeg_quality) {
  char name[16];
  std::snprintf(name, sizeof(name), "%05d", number);
  auto done = WriteColour(frame, folder / "frames" / (std::string(name) + ".jpg"), jpeg_quality);
  if (done) done = WriteRangePng(frame, folder / "range" / (std::string(name) + ".png"));
  if (done) done = WriteObjectsPng(frame, folder / "object" / (std::string(name) + ".png"));
  return done;
}

core::Expected<void> WriteCamera(const fs::path& file, const vision::CameraChoice& optics) {
  const std::string text = DumpCamera(optics);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(file.c_str(), "w"),
                                                            std::fclose);
  if (out && std::fputs(text.c_str(), out.get()) >= 0 && std::fflush(out.get()) == 0) return {};
  return tl::unexpected(core::ErrnoError("write " + file.string(), errno));
}

}  // namespace

core::Expected<SurveySummary> RenderSurvey(const SiteWorld& world, const SurveyOptions& options,
                                           const std::atomic<bool>& stop) {
  auto optics = vision::MakeCamera(options.optics);
  if (!optics) return tl::unexpected(optics.error());
  if (auto made = MakeFolders(options.folder); !made) return tl::unexpected(made.error());
  auto done = WriteWorldTruth(world, options.folder);
  if (done) done = WriteCamera(options.folder / "camera.yaml", options.optics);
  if (!done) return tl::unexpected(done.error());
  const RenderedPictures pictures(world, *optics, options.camera);
  const std::vector<core::GpsTime> instants = Exposures(world, options);
  PoseTable measured(options.folder / "poses.csv"), truth(options.folder / "truth_frames.csv");
  auto record = TruthRecorder::Create(options.folder / "truth.lcm", world,
                                      instants.empty() ? world.trajectory().begin() : instants[0]);
  if (!record) return tl::unexpected(record.error());
  Dice dice(options.noise_seed);

  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  double told_s = 0.0;
  SurveySummary summary;
  for (const core::GpsTime t : instants) {
    if (stop.load()) break;
    const int number = summary.frames + 1;
    const CameraPose pose = PoseAt(world, t);
    done = WriteFrame(options.folder, number, pictures.Render(t), options.camera.jpeg_quality);
    if (done) done = truth.Add(number, t, pose, 0.0, 0.0);
    if (done) done = record->Exposure(0, number, t, {});
    if (done) {
      done = measured.Add(number, t, WithNoise(pose, options, dice), options.pose_noise_m,
                          options.attitude_noise_deg);
    }
    if (!done) return tl::unexpected(done.error());
    summary.frames = number;
    if (seconds() - told_s > 5.0) {
      told_s = seconds();
      std::printf("kawara-sim: %d of %zu frames\n", number, instants.size());
      std::fflush(stdout);
    }
  }
  if (done = record->Close(); !done) return tl::unexpected(done.error());
  summary.way_m = summary.frames > 0 ? (summary.frames - 1) * options.every_m : 0.0;
  summary.seconds_a_frame = summary.frames > 0 ? seconds() / summary.frames : 0.0;
  return summary;
}

}  // namespace kawara::sim
