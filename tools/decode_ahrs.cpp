#include <Eigen/Core>

#include "core/geodesy.hpp"
#include "drivers/ahrs400.hpp"
#include "tools/decode_common.hpp"

namespace kawara::tools {
namespace {

using drivers::Ahrs400Mode;

/// One line a packet or reply. Angles in degrees as in all our files, everything else SI;
/// accelerations with the unit's own sign unless --acceleration-sign says otherwise.
class Printer : public drivers::Ahrs400Sink {
 public:
  Printer(JsonLines& out, const drivers::Ahrs400Decoder& decoder, std::uint64_t first_offset,
          bool silent)
      : out_(out), decoder_(decoder), first_offset_(first_offset), silent_(silent) {}

  void OnSample(const core::AhrsSample& sample, Ahrs400Mode mode) override {
    if (!Begin(TypeOf(mode))) return;
    if (sample.has_attitude) {
      out_.Number("roll_deg", sample.attitude.roll_rad * core::kDegFromRad, 6);
      out_.Number("pitch_deg", sample.attitude.pitch_rad * core::kDegFromRad, 6);
      out_.Number("heading_magnetic_deg", sample.attitude.yaw_rad * core::kDegFromRad, 6);
    }
    Vector("rate_radps", sample.rate_radps, 9);
    Vector("acceleration_mps2", sample.specific_force_mps2, 9);
    constexpr double kTeslaPerGauss = 1e-4;
    Vector("magnetic_tesla", sample.magnetic_gauss * kTeslaPerGauss, 13);
    out_.Number("temperature_degc", sample.temperature_degc, 4);
    Counter(sample.counter);
    out_.End();
  }

  void OnVoltages(const drivers::Ahrs400Voltages& v) override {
    if (!Begin(TypeOf(Ahrs400Mode::kVoltage))) return;
    Vector("gyro_v", Eigen::Map<const Eigen::Vector3d>(v.gyro_v.data()), 7);
    Vector("accelerometer_v", Eigen::Map<const Eigen::Vector3d>(v.accelerometer_v.data()), 7);
    Vector("magnetometer_v", Eigen::Map<const Eigen::Vector3d>(v.magnetometer_v.data()), 7);
    out_.Number("temperature_degc", v.temperature_degc, 4);
    Counter(v.counter);
    out_.End();
  }

  void OnFrozen(core::MonoTime /*arrival*/, Ahrs400Mode mode) override {
    if (!Begin(TypeOf(mode))) return;
    out_.Boolean("frozen", true);
    out_.End();
  }

  void OnVersion(std::string_view text) override {
    if (!Begin("AHRS.version")) return;
    out_.Text("version", text.substr(0, text.find_last_not_of(' ') + 1));
    out_.End();
  }

  void OnSerialNumber(std::uint32_t number) override {
    if (!Begin("AHRS.serial")) return;
    out_.Unsigned("serial_number", number);
    out_.End();
  }

  TypeCounts types;

 private:
  static std::string TypeOf(Ahrs400Mode mode) { return std::string("AHRS.") + ToString(mode); }

  /// Counts the message; true if it is to be printed.
  bool Begin(std::string_view type) {
    types.Count(type);
    if (silent_) return false;
    out_.Begin(type);
    out_.Unsigned("offset", first_offset_ + decoder_.position());
    return true;
  }

  void Vector(std::string_view key, const Eigen::Vector3d& v, int decimals) {
    out_.OpenArray(key);
    for (const double x : v) out_.Number("", x, decimals);
    out_.CloseArray();
  }

  /// The counter runs down and wraps every 51.8 ms: what passed since the last packet is known up
  /// to that.
  void Counter(std::uint16_t counter) {
    out_.Unsigned("counter", counter);
    if (has_counter_) {
      const auto ticks = static_cast<std::uint16_t>(last_counter_ - counter);
      out_.Number("step_modulo_wrap_s", ticks * drivers::kAhrs400TickNs * 1e-9, 9);
    } else {
      out_.Null("step_modulo_wrap_s");
    }
    last_counter_ = counter;
    has_counter_ = true;
  }

  JsonLines& out_;
  const drivers::Ahrs400Decoder& decoder_;
  std::uint64_t first_offset_;
  bool silent_;
  bool has_counter_ = false;
  std::uint16_t last_counter_ = 0;
};

}  // namespace

int DecodeAhrs(ByteSource& source, JsonLines& out, const DecodeOptions& options) {
  const double sign = options.acceleration_sign;
  drivers::Ahrs400Config config;
  config.scaling = options.scaling == 200 ? drivers::Ahrs400Scaling::Model200(sign)
                                          : drivers::Ahrs400Scaling::Model100(sign);
  if (options.voltage) config.mode = Ahrs400Mode::kVoltage;
  drivers::Ahrs400Decoder decoder(config);
  auto bytes = source.Read();  // the first block tells how many bytes of remarks there are
  Printer printer(out, decoder, source.comment_bytes(), options.summary_only);
  for (; !bytes.empty() && out.ok(); bytes = source.Read()) {
    decoder.Feed(core::MonoTime{}, bytes, printer);
  }
  decoder.Finish(printer);

  const drivers::Ahrs400Stats& stats = decoder.stats();
  DecodeSummary summary;
  summary.good = stats.Good();
  summary.bad_checksum = stats.bad_checksum;
  summary.skipped_bytes = stats.skipped_bytes;
  summary.good_bytes = stats.packets[0] * drivers::kAhrs400AnglePacketBytes +
                       (stats.packets[1] + stats.packets[2]) * drivers::kAhrs400ShortPacketBytes +
                       stats.versions * drivers::kAhrs400VersionBytes +
                       stats.serial_numbers * drivers::kAhrs400SerialBytes;
  summary.comment_bytes = source.comment_bytes();
  summary.types = printer.types;
  WriteSummary(out, summary, [&](JsonLines& json) {
    json.Unsigned("frozen", stats.frozen);
    json.Unsigned("locks", stats.locks);
  });
  return 0;
}

}  // namespace kawara::tools
