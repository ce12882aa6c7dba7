#include "tools/navigate/sensor_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace kawara::navigate {
namespace {

using Kind = CsvColumn::Kind;

constexpr std::array<CsvColumn, 7> kImuColumns{
    {{"t", Kind::kTime}, {"wx"}, {"wy"}, {"wz"}, {"ax"}, {"ay"}, {"az"}}};
constexpr std::array<CsvColumn, 3> kOdometryColumns{
    {{"t", Kind::kTime}, {"vx"}, {"wz", Kind::kOptionalNumber}}};
constexpr std::array<CsvColumn, 4> kAttitudeColumns{
    {{"t", Kind::kTime}, {"roll"}, {"pitch"}, {"yaw", Kind::kOptionalNumber}}};
constexpr std::array<CsvColumn, 4> kWindowColumns{{{"t_start", Kind::kTime},
                                                   {"t_end", Kind::kTime},
                                                   {"run", Kind::kOptionalNumber},
                                                   {"length_s", Kind::kOptionalNumber}}};
constexpr std::array<CsvColumn, 1> kEpochColumns{{{"t", Kind::kTime}}};

/// Reads a whole file; `take` makes a sample of a row, or says why it cannot.
template <class Sample, class Take>
core::Expected<SampleFile<Sample>> ReadAll(CsvReader reader, Take take) {
  SampleFile<Sample> file;
  for (;;) {
    const auto row = reader.Next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) break;
    Sample sample;
    if (const std::string wrong = take(**row, sample); !wrong.empty()) {
      reader.Reject(wrong);
    } else {
      file.rows.push_back(std::move(sample));
    }
  }
  file.report = reader.report();
  return file;
}

bool IsAngle(double deg) { return std::abs(deg) <= 360.0; }

}  // namespace

core::Expected<ImuFile> ImuFile::Open(const std::string& path) {
  auto reader = CsvReader::Open(path, kImuColumns);
  if (!reader) return tl::unexpected(reader.error());
  return ImuFile(std::move(*reader));
}

core::Expected<std::optional<estimation::ImuSample>> ImuFile::Next() {
  const auto row = reader_.Next();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return std::optional<estimation::ImuSample>();
  const auto& n = (*row)->number;
  estimation::ImuSample sample;
  sample.time = *(*row)->time[0];
  sample.rate_radps << n[1], n[2], n[3];
  sample.specific_force_mps2 << n[4], n[5], n[6];
  return std::optional(sample);
}

core::Expected<SampleFile<estimation::OdometrySample>> ReadOdometry(const std::string& path) {
  auto reader = CsvReader::Open(path, kOdometryColumns);
  if (!reader) return tl::unexpected(reader.error());
  return ReadAll<estimation::OdometrySample>(
      std::move(*reader), [](const CsvReader::Row& row, estimation::OdometrySample& sample) {
        sample.time = *row.time[0];
        sample.speed_mps = row.number[1];
        sample.has_turn_rate = !std::isnan(row.number[2]);
        if (sample.has_turn_rate) sample.turn_rate_radps = row.number[2];
        return std::string();
      });
}

core::Expected<SampleFile<estimation::AttitudeSample>> ReadAttitude(const std::string& path) {
  auto reader = CsvReader::Open(path, kAttitudeColumns);
  if (!reader) return tl::unexpected(reader.error());
  return ReadAll<estimation::AttitudeSample>(
      std::move(*reader), [](const CsvReader::Row& row, estimation::AttitudeSample& sample) {
        if (!IsAngle(row.number[1]) || !IsAngle(row.number[2]) || std::abs(row.number[3]) > 360.0) {
          return std::string("an angle beyond 360 degrees");
        }
        sample.time = *row.time[0];
        sample.has_level = true;
        sample.attitude.roll_rad = row.number[1] * core::kRadFromDeg;
        sample.attitude.pitch_rad = row.number[2] * core::kRadFromDeg;
        sample.has_heading = !std::isnan(row.number[3]);
        if (sample.has_heading) sample.attitude.yaw_rad = row.number[3] * core::kRadFromDeg;
        return std::string();
      });
}

core::Expected<SampleFile<TimeWindow>> ReadWindows(const std::string& path,
                                                   std::optional<int> run) {
  auto reader = CsvReader::Open(path, kWindowColumns, CsvReader::Header::kOptional);
  if (!reader) return tl::unexpected(reader.error());
  const bool has_runs = reader->Has(2);
  if (run && !has_runs) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path + ":1: no column 'run', which --blank-run needs");
  }
  std::set<double> runs;
  struct Read {
    TimeWindow window;
    double run = 0.0;
  };
  auto all = ReadAll<Read>(std::move(*reader), [&](const CsvReader::Row& row, Read& read) {
    read.window = {*row.time[0], *row.time[1]};
    read.run = row.number[2];
    if (read.window.end <= read.window.begin) {
      return std::string("t_end must be later than t_start");
    }
    if (has_runs && std::isnan(read.run)) return std::string("run is missing");
    runs.insert(read.run);
    return std::string();
  });
  if (!all) return tl::unexpected(all.error());
  if (has_runs && !run && runs.size() > 1) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path + ": holds the windows of " + std::to_string(runs.size()) +
                          " runs: choose one with --blank-run N");
  }
  SampleFile<TimeWindow> file;
  file.report = std::move(all->report);
  for (const Read& read : all->rows) {
    if (!run || read.run == static_cast<double>(*run)) file.rows.push_back(read.window);
  }
  if (file.rows.empty()) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path + ": no window of run " + std::to_string(*run));
  }
  std::ranges::sort(file.rows, {}, &TimeWindow::begin);
  return file;
}

core::Expected<SampleFile<core::GpsTime>> ReadEpochs(const std::string& path) {
  auto reader = CsvReader::Open(path, kEpochColumns, CsvReader::Header::kOptional);
  if (!reader) return tl::unexpected(reader.error());
  auto file = ReadAll<core::GpsTime>(std::move(*reader),
                                     [](const CsvReader::Row& row, core::GpsTime& epoch) {
                                       epoch = *row.time[0];
                                       return std::string();
                                     });
  if (file) std::ranges::sort(file->rows);
  return file;
}

}  // namespace kawara::navigate
