#include "sim/sim_options.hpp"

#include <map>

#include "core/iso8601.hpp"
#include "sim/camera/camera_file.hpp"
#include "sim/render/light_cache.hpp"

namespace kawara::sim {
namespace {

void AddInstrumentOptions(CLI::App& app, InstrumentOptions& o, InstrumentTexts& texts) {
  app.add_option("--run-dir", o.run_dir,
                 "folder for the ports: gps, ahrs, pps.sock, camera.sock, ready, truth_*.csv")
      ->required();
  app.add_option("--speed", o.speed,
                 "pace; other than 1 the instruments' clocks no longer fit this machine's")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  app.add_option(
         "--fault", texts.faults,
         "\"t=30 gps.unplug 5s\": at 30 s of the run, for 5 s (default 5). All there are: " +
             AllFaultNames() + ". Repeatable")
      ->allow_extra_args(false);
  app.add_option("--virtual", texts.virtual_log,
                 "virtual time: instruments and kawara-onboard's core in this process, as fast as "
                 "it goes; what kawara-onboard would record goes into this LCM log, which must not "
                 "exist. No ports then")
      ->group("Virtual time");
  app.add_option("--onboard-config", texts.onboard_config, "the robot's YAML, with --virtual")
      ->group("Virtual time");
  app.add_option("--onboard-set", texts.onboard_set, "key=value over it; repeatable")
      ->allow_extra_args(false)
      ->group("Virtual time");
  app.add_option("--lcm-url", o.lcm_url,
                 "listen there for faults ordered while it runs ('kawara-sim fault'); empty: LCM's "
                 "default bus. Without it nothing is listened to");
  app.add_option("--command-channel", o.command_channel, "on which they come")
      ->capture_default_str();
  app.add_option("--lead", o.lead_s, "seconds between ready and the first instant")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  app.add_option("--skew-ppm", o.machine_skew_ppm,
                 "GPS time runs this much faster than this machine's clock")
      ->check(CLI::Range(-1000.0, 1000.0));
  app.add_flag("!--no-realtime", o.realtime, "do not ask for real-time priority");

  app.add_option("--gps-port", o.gps.port, "receiver's port the cable is in, A..D")
      ->check(CLI::IsMember(std::map<std::string, int>{{"A", 0}, {"B", 1}, {"C", 2}, {"D", 3}}))
      ->group("GPS receiver");
  app.add_option("--gps-baud", o.gps.baud_bps, "rate saved in the receiver")
      ->check(CLI::IsMember({300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200}))
      ->capture_default_str()
      ->group("GPS receiver");
  app.add_option("--gps-preset", o.gps.streaming,
                 "what is saved in the receiver: off, or streaming (all sentences on, CPD working)")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, bool>{{"off", false}, {"streaming", true}}))
      ->group("GPS receiver");
  app.add_option("--gga-quality", o.gps.gga_quality,
                 "GGA field 6: legacy (3 fixed, 2 float) or nmea23 (4, 5)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, GgaQuality>{
          {"legacy", GgaQuality::kAshtechLegacy}, {"nmea23", GgaQuality::kNmea23}}))
      ->group("GPS receiver");
  app.add_option("--gps-latency", o.gps.latency_s, "seconds from epoch to first bit")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str()
      ->group("GPS receiver");
  app.add_option("--gps-jitter", o.gps.latency_jitter_s,
                 "mean of the random part of the latency [s]")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str()
      ->group("GPS receiver");
  app.add_flag("--needs-corrections", o.gps.needs_corrections,
               "without RTCM on its port the receiver loses its fix")
      ->group("GPS receiver");

  app.add_flag("!--ahrs-quiet", o.ahrs.already_streaming,
               "unit starts polled instead of streaming from the last run")
      ->group("AHRS");
  app.add_option("--ahrs-skew-ppm", o.ahrs.counter_skew_ppm, "its crystal against this machine's")
      ->check(CLI::Range(-10000.0, 10000.0))
      ->capture_default_str()
      ->group("AHRS");
  app.add_option("--ahrs-range", o.ahrs.ranges.rate_degps, "model: 100 (2 g) or 200 (4 g)")
      ->check(CLI::IsMember({100.0, 200.0}))
      ->capture_default_str()
      ->group("AHRS");
  app.add_option("--ahrs-accel-sign", o.ahrs.ranges.force_sign,
                 "1: specific force as it is; -1: negated")
      ->check(CLI::IsMember({1.0, -1.0}))
      ->group("AHRS");

  app.add_option("--pps-latency", o.pulses.latency_s, "pulse to the stamp of its edge, least [s]")
      ->check(CLI::Range(0.0, 0.1))
      ->capture_default_str()
      ->group("Pulse line");
  app.add_option("--pps-jitter", o.pulses.jitter_s, "mean of what comes on top [s]")
      ->check(CLI::Range(0.0, 0.1))
      ->capture_default_str()
      ->group("Pulse line");

  app.add_option("--camera-delay", o.camera.exposure_delay_s, "trigger to start of exposure [s]")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group("Camera");
  app.add_option("--camera-jitter", o.camera.exposure_jitter_s, "standard deviation of it [s]")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group("Camera");
  app.add_option("--camera-readout", o.camera.readout_s,
                 "start of exposure to first byte of the frame, least [s]")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str()
      ->group("Camera");
  app.add_flag("!--camera-nameless", o.camera.names_trigger,
               "frames do not say which trigger made them, as cameras of the kernel's")
      ->group("Camera");
  app.add_option("--camera-stamp-late", o.camera.stamp_late_s,
                 "its stamps lie so much after the start of the exposure, mean [s]")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group("Camera");
  app.add_option("--camera-stamp-jitter", o.camera.stamp_jitter_s, "standard deviation of it [s]")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group("Camera");
  app.add_flag("--camera-strobe", o.camera.signals_exposure,
               "the receiver's event input is wired to the camera's sign that it exposes, not to "
               "its trigger")
      ->group("Camera");
}

void AddWorldOptions(CLI::App& app, SiteWorldOptions& o) {
  o.site = DefaultConfig("sites/factory_road.yaml");
  o.robot = DefaultConfig("vehicles/survey_robot.yaml");
  o.begin = core::ToGps(core::FromCivil({2026, 1, 17, 5, 46, 52}));
  app.add_option("--site", o.site, "the place (configs/sites)")->capture_default_str();
  app.add_option("--robot", o.robot, "vehicle and sensors (configs/vehicles)")
      ->capture_default_str();
  app.add_option("--set", o.set, "dotted.key=value over the site file; repeatable")
      ->allow_extra_args(false);
  app.add_option("--seed", o.seed, "of all chance in the drive")->capture_default_str();
  app.add_option_function<std::string>(
         "--begin",
         [&o](const std::string& text) {
           const auto begin = core::ParseIso8601(text);
           if (!begin) throw CLI::ValidationError("--begin", begin.error().message);
           o.begin = core::ToGps(*begin);
         },
         "of the mission, ISO 8601: when the vehicle begins to stand")
      ->default_str("2026-01-17T05:46:52Z");
  app.add_option(
         "--light-cell", o.light.cell_m,
         "metres between the points where light is measured before the first picture; more is "
         "faster and rougher")
      ->check(CLI::Range(0.2, 50.0))
      ->capture_default_str();
  o.light.cache = LightCache::DefaultFolder();
  app.add_option("--light-cache", o.light.cache,
                 "folder in which measured light is kept for the next run; \"\": nowhere")
      ->capture_default_str();
}

void AddRenderingOptions(CLI::App& app, vision::CameraChoice& optics, RenderedCameraOptions& o) {
  CLI::Option* ring =
      app.add_option_function<int>(
             "--doughnut-px",
             [&optics](int px) { optics = vision::CameraChoice::Of(StandardDoughnut(px)); },
             "side of the standard doughnut picture (default 1448: 2.1 megapixels)")
          ->check(CLI::Range(256, 4096))
          ->group("Camera");
  app.add_option_function<std::string>(
         "--camera",
         [&optics](const std::string& path) {
           auto choice = LoadCamera(path);
           if (!choice) throw CLI::ValidationError(choice.error().message);
           optics = std::move(*choice);
         },
         "the camera's YAML instead: camera: doughnut or equirectangular, and its numbers (as the "
         "camera.yaml of a survey, or picture: of a robot's configuration)")
      ->excludes(ring)
      ->group("Camera");
  app.add_option("--exposure", o.exposure_s, "[s]")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str()
      ->group("Camera");
  app.add_option("--rolling-shutter", o.readout_s, "from the first row to the last [s]; 0: global")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str()
      ->group("Camera");
  app.add_option("--samples", o.settings.samples, "rays a pixel at edges")
      ->check(CLI::Range(1, 17))
      ->capture_default_str()
      ->group("Camera");
  app.add_option("--threads", o.settings.threads, "for rendering; 0: all")
      ->check(CLI::Range(0, 256))
      ->capture_default_str()
      ->group("Camera");
  app.add_flag("!--no-body", o.robot_in_view, "the robot's own body is not in view")
      ->group("Camera");
  app.add_option("--jpeg-quality", o.jpeg_quality, "")
      ->check(CLI::Range(30, 100))
      ->capture_default_str()
      ->group("Camera");
}

}  // namespace

std::filesystem::path DefaultConfig(const std::string& name) {
  std::error_code ignored;
  const std::filesystem::path here = std::filesystem::path("configs") / name;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::filesystem::path beside =
      program.parent_path().parent_path().parent_path() / "configs" / name;
  for (const auto& path : {here, beside}) {
    if (std::filesystem::exists(path, ignored)) return path;
  }
  return here;
}

void AddDriveOptions(CLI::App& app, DriveOptions& o, InstrumentTexts& texts) {
  app.add_option("--data", o.data, "folder of the recording: gnss.csv[.gz], imu.csv[.gz], site.csv")
      ->required();
  app.add_option("--panorama", o.panorama,
                 "stitched 360 degree JPEG to render doughnut pictures from, or a folder of JPEGs "
                 "to send in order; without it there is no camera");
  app.add_option("--start", o.start_s, "seconds into the recording")->check(CLI::NonNegativeNumber);
  app.add_option("--duration", o.duration_s,
                 "seconds of recording to replay; to its end if not given")
      ->check(CLI::PositiveNumber);
  app.add_flag("--now", o.now,
               "move the recording by whole seconds, so that its start is the present");
  app.add_option("--imu-advance", o.imu_advance_s,
                 "seconds by which IMU stamps are moved back (0.09 takes out the drive's lateness)")
      ->check(CLI::Range(-1.0, 1.0));
  app.add_option("--seed", o.instruments.gps.seed, "of all random delays and errors")
      ->capture_default_str();
  app.add_option_function<int>(
         "--doughnut-px", [&o](int px) { o.doughnut = StandardDoughnut(px); },
         "side of the doughnut picture (default 2048)")
      ->check(CLI::Range(256, 4096))
      ->group("Camera");
  app.add_option("--jpeg-quality", o.jpeg_quality, "")
      ->check(CLI::Range(30, 100))
      ->capture_default_str()
      ->group("Camera");
  AddInstrumentOptions(app, o.instruments, texts);
}

void AddSiteOptions(CLI::App& app, SiteRunOptions& o, InstrumentTexts& texts) {
  AddWorldOptions(app, o.world);
  app.add_option("--start", o.start_s, "seconds into the drive")->check(CLI::NonNegativeNumber);
  app.add_option("--duration", o.duration_s, "seconds of it; to its end if not given")
      ->check(CLI::PositiveNumber);
  app.add_flag("--now", o.now, "it begins at the present; otherwise always at the same date");
  app.add_flag("!--no-camera", o.camera, "only serial instruments");
  app.add_option("--ahead", o.ahead_period_s,
                 "draw the exposures every so many seconds before the run begins, if this machine "
                 "is too slow to draw them while it runs (pictures that are not ready at their "
                 "trigger come later; the last line counts them)")
      ->check(CLI::Range(0.05, 3600.0));
  AddRenderingOptions(app, o.optics, o.rendering);
  AddInstrumentOptions(app, o.instruments, texts);
}

void AddRadioOptions(CLI::App& app, RadioRunOptions& o, std::vector<std::string>& faults) {
  app.add_option("--robot", o.relay.robot_url, "the robot's LCM bus")->capture_default_str();
  app.add_option("--base", o.relay.base_url, "the base station's LCM bus")->capture_default_str();
  app.add_option("--duration", o.duration_s, "seconds; until stopped if not given")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", o.relay.seed, "of all loss and jitter")->capture_default_str();
  app.add_option("--fault", faults,
                 "\"t=30 radio.loss=0.3 5s\": at 30 s of the run, for 5 s (default 5). All there "
                 "are: radio.down, radio.loss=SHARE, radio.burst=SHARE, radio.rate=BITS_PER_S, "
                 "radio.delay=SECONDS. Repeatable")
      ->allow_extra_args(false);
  app.add_option("--command-channel", o.command_channel,
                 "of the robot's bus, on which kawara-sim fault orders more")
      ->capture_default_str();
  RadioOptions& air = o.relay.down;
  app.add_option("--rate", air.rate_bps, "bits per second of the air, each way; 0: no limit")
      ->check(CLI::Range(0.0, 1e10))
      ->group("Air");
  app.add_option("--queue", air.queue_bytes, "bytes that wait for it; what comes then is dropped")
      ->check(CLI::Range(std::size_t{2000}, std::size_t{1} << 30))
      ->capture_default_str()
      ->group("Air");
  app.add_option("--delay", air.delay_s, "seconds to the other side")
      ->check(CLI::Range(0.0, 60.0))
      ->group("Air");
  app.add_option("--jitter", air.jitter_s, "mean of an exponential delay on top [s]")
      ->check(CLI::Range(0.0, 60.0))
      ->group("Air");
  app.add_option("--loss", air.loss,
                 "share of IP packets lost one by one (an LCM datagram is up to 45)")
      ->check(CLI::Range(0.0, 1.0))
      ->group("Air");
  app.add_option("--burst", air.burst_loss, "share of IP packets lost in fades")
      ->check(CLI::Range(0.0, 0.99))
      ->group("Air");
  app.add_option("--burst-length", air.burst_length, "mean number of packets lost in a fade")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str()
      ->group("Air");
}

void AddSurveyOptions(CLI::App& app, SiteWorldOptions& world, SurveyOptions& o) {
  AddWorldOptions(app, world);
  o.optics = vision::CameraChoice::Of(StandardDoughnut(1448));
  app.add_option("--every", o.every_m, "metres between frames")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  app.add_option("--start", o.start_s, "seconds into the drive")->check(CLI::NonNegativeNumber);
  app.add_option("--duration", o.duration_s, "seconds of it; to its end if not given")
      ->check(CLI::PositiveNumber);
  app.add_option("--pose-noise", o.pose_noise_m, "of poses.csv, each axis [m]")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--attitude-noise", o.attitude_noise_deg, "of poses.csv, each axis [deg]")
      ->check(CLI::Range(0.0, 45.0))
      ->capture_default_str();
  AddRenderingOptions(app, o.optics, o.camera);
}

void AddFaultCommandOptions(CLI::App& app, FaultCommandOptions& o) {
  app.add_option("order", o.text,
                 "\"gps.unplug 5s\": from now; \"t=30 gps.unplug 5s\": from the start of the run; "
                 "several separated by ';'; \"clear\" ends all. All there are: " +
                     AllFaultNames())
      ->required();
  app.add_option("--lcm-url", o.lcm_url, "the simulator's --lcm-url; empty: LCM's default bus");
  app.add_option("--command-channel", o.channel, "the simulator's")->capture_default_str();
  app.add_option("--timeout", o.patience_s, "seconds to wait for its answer")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

}  // namespace kawara::sim
