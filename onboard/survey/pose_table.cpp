#include "onboard/survey/pose_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

#include "onboard/survey/node_reading.hpp"
#include "onboard/survey/table_text.hpp"

namespace kawara::survey {
namespace {

constexpr std::size_t kMaxRows = 2'000'000;
constexpr double kMaxMetres = 1e8;

/// Reads one line after the other by the columns of the header.
class PoseReader {
 public:
  PoseReader(const std::string& source, BodyAxes body, const std::optional<core::Geodetic>& origin)
      : source_(source), body_(body), origin_(origin) {}

  core::Expected<void> Header(const std::vector<std::string_view>& names, int line) {
    names_.assign(names.begin(), names.end());
    line_ = line;
    place_ = First({{"lat_deg", "lon_deg", "h_ellipsoidal_m"},
                    {"lat_deg", "lon_deg", "h_m"},
                    {"lat_deg", "lon_deg", "h"}});
    geodetic_ = !place_.empty();
    if (!geodetic_) place_ = First({{"x", "y", "z"}, {"x_m", "y_m", "z_m"}});
    quaternion_ = First({{"qw", "qx", "qy", "qz"}});
    angles_ = First({{"roll_deg", "pitch_deg", "yaw_deg"}});
    if (place_.empty()) {
      return Wrong("columns lat_deg, lon_deg, h_ellipsoidal_m or x, y, z: missing");
    }
    if (quaternion_.empty() && angles_.empty()) {
      return Wrong("columns qw, qx, qy, qz or roll_deg, pitch_deg, yaw_deg: missing");
    }
    sd_place_ = First({{"sd_east_m", "sd_north_m", "sd_up_m"},
                       {"sd_x_m", "sd_y_m", "sd_z_m"},
                       {"sd_position_m", "sd_position_m", "sd_position_m"}});
    sd_turn_ = First({{"sd_roll_deg", "sd_pitch_deg", "sd_yaw_deg"},
                      {"sd_attitude_deg", "sd_attitude_deg", "sd_attitude_deg"}});
    return {};
  }

  core::Expected<void> Row(std::vector<std::string_view> fields, int line) {
    line_ = line;
    // Separators at the end of lines part nothing.
    while (fields.size() > names_.size() && fields.back().empty()) fields.pop_back();
    fields_ = &fields;
    if (fields.size() != names_.size()) {
      return Wrong(std::to_string(fields.size()) + " fields, the header has " +
                   std::to_string(names_.size()));
    }
    if (table.rows.size() >= kMaxRows) return Wrong("more than 2 million poses");
    if (std::ranges::all_of(place_, [&](std::size_t at) { return IsUnknown(fields[at]); })) {
      ++table.rows_without_place;
      return {};
    }
    PoseRow row;
    if (const auto at = Column("file"); at) row.name = fields[*at];
    if (const auto at = Column("frame"); row.name.empty() && at) row.name = fields[*at];
    if (const auto at = Column("camera"); at) row.camera = fields[*at];
    if (auto good = ReadTime(row); !good) return good;
    if (auto good = ReadPose(row); !good) return good;
    if (auto good = ReadDeviations(row); !good) return good;
    table.rows.push_back(row);
    return {};
  }

  tl::unexpected<core::Error> Wrong(const std::string& what) const {
    return core::Fail(core::ErrorCode::kFormat,
                      source_ + ":" + std::to_string(line_) + ": " + what);
  }

  PoseTable table;

 private:
  using Columns = std::vector<std::size_t>;

  std::optional<std::size_t> Column(std::string_view name) const {
    const auto found = std::ranges::find(names_, name);
    if (found == names_.end()) return {};
    return static_cast<std::size_t>(found - names_.begin());
  }

  /// The first group of names that is there as a whole.
  Columns First(std::initializer_list<std::initializer_list<std::string_view>> groups) const {
    for (const auto& group : groups) {
      Columns columns;
      for (const std::string_view name : group) {
        if (const auto at = Column(name); at) columns.push_back(*at);
      }
      if (columns.size() == group.size()) return columns;
    }
    return {};
  }

  core::Expected<Eigen::Vector4d> Numbers(const Columns& columns) const {
    Eigen::Vector4d numbers = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto value = Number((*fields_)[columns[i]]);
      if (!value) return Wrong(names_[columns[i]] + ": expected a number");
      numbers[static_cast<Eigen::Index>(i)] = *value;
    }
    return numbers;
  }

  core::Expected<void> ReadTime(PoseRow& row) const {
    for (const char* name : {"gps_ns", "t_ns"}) {
      const auto at = Column(name);
      if (!at) continue;
      const auto ns = Integer((*fields_)[*at]);
      if (!ns) return Wrong(std::string(name) + ": expected whole nanoseconds");
      row.time = core::GpsTime::FromNs(*ns);
      return {};
    }
    for (const char* name : {"t", "t_s", "time_s"}) {
      const auto at = Column(name);
      if (!at) continue;
      const auto ns = NanosecondsOf((*fields_)[*at]);
      if (!ns) return Wrong(std::string(name) + ": expected seconds");
      row.time = core::GpsTime::FromNs(*ns);
      return {};
    }
    return {};
  }

  core::Expected<void> ReadPose(PoseRow& row) {
    const auto place = Numbers(place_);
    if (!place) return tl::unexpected(place.error());
    const auto turn = Numbers(quaternion_.empty() ? angles_ : quaternion_);
    if (!turn) return tl::unexpected(turn.error());
    Eigen::Matrix3d R_enu_ned = Eigen::Matrix3d::Identity();
    if (geodetic_) {
      if (std::abs((*place)[0]) > 90.0 || std::abs((*place)[1]) > 360.0 ||
          std::abs((*place)[2]) > kMaxMetres) {
        return Wrong("lat_deg, lon_deg, height: not on the Earth");
      }
      const core::Geodetic here{(*place)[0] * core::kRadFromDeg, (*place)[1] * core::kRadFromDeg,
                                (*place)[2]};
      if (!map_) {
        table.origin = origin_.value_or(here);
        map_.emplace(*table.origin);
      }
      row.map_from_body.translation() = map_->FromGeodetic(here);
      R_enu_ned = core::RotationEnuFromNed(*table.origin, here);
    } else {
      if (!(place->head<3>().cwiseAbs().maxCoeff() <= kMaxMetres)) {
        return Wrong("x, y, z: farther than 1e8 m");
      }
      row.map_from_body.translation() = place->head<3>();
    }
    if (!quaternion_.empty()) {
      const auto q = QuaternionOf((*turn)[0], (*turn)[1], (*turn)[2], (*turn)[3]);
      if (!q) return Wrong(q.error().message);
      row.map_from_body.linear() = q->toRotationMatrix();
      return {};
    }
    const Eigen::Vector3d angles_rad = turn->head<3>() * core::kRadFromDeg;
    Eigen::Matrix3d R = core::RotationNedFromBody({angles_rad.x(), angles_rad.y(), angles_rad.z()});
    const Eigen::Matrix3d turned_over = Eigen::Vector3d(1, -1, -1).asDiagonal();
    const bool is_up = !geodetic_;
    if (is_up != (body_ == BodyAxes::kForwardLeftUp)) R = (R * turned_over).eval();
    row.map_from_body.linear() = geodetic_ ? Eigen::Matrix3d(R_enu_ned * R) : R;
    return {};
  }

  core::Expected<void> ReadDeviations(PoseRow& row) const {
    if (sd_place_.empty() || sd_turn_.empty()) return {};
    const auto place_m = Numbers(sd_place_);
    if (!place_m) return tl::unexpected(place_m.error());
    const auto turn_deg = Numbers(sd_turn_);
    if (!turn_deg) return tl::unexpected(turn_deg.error());
    if (place_m->minCoeff() < 0.0 || turn_deg->minCoeff() < 0.0) {
      return Wrong("a standard deviation is negative");
    }
    Eigen::Matrix<double, 6, 1> deviations;
    deviations << place_m->head<3>(), turn_deg->head<3>() * core::kRadFromDeg;
    row.covariance = deviations.cwiseAbs2().asDiagonal();
    row.has_covariance = true;
    return {};
  }

  const std::string& source_;
  const BodyAxes body_;
  const std::optional<core::Geodetic> origin_;
  int line_ = 0;
  std::vector<std::string> names_;
  const std::vector<std::string_view>* fields_ = nullptr;
  Columns place_, quaternion_, angles_, sd_place_, sd_turn_;
  bool geodetic_ = false;
  std::optional<core::LocalEnu> map_;
};

}  // namespace

core::Expected<PoseTable> ParsePoses(std::string_view text, const std::string& source,
                                     BodyAxes body, const std::optional<core::Geodetic>& origin) {
  constexpr std::array<std::string_view, 8> kTum = {"t", "x", "y", "z", "qx", "qy", "qz", "qw"};
  PoseReader reader(source, body, origin);
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  bool has_header = false;
  char separator = ',';
  std::string with_points;
  for (int line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = Trimmed(text.substr(0, end));
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    if (line.empty() || line.front() == '#') continue;
    core::Expected<void> good;
    if (!has_header) {
      has_header = true;
      separator = SeparatorOf(line);
      if (separator == ';') {
        with_points = text;
        std::ranges::replace(with_points, ',', '.');
        text = with_points;
      }
      const auto first = Fields(line, separator);
      const bool numbers = std::ranges::all_of(first, [](auto f) { return Number(f).has_value(); });
      if (numbers && first.size() == kTum.size() && separator == ' ') {
        good = reader.Header({kTum.begin(), kTum.end()}, line_number);
        if (good) good = reader.Row(first, line_number);
      } else if (numbers) {
        return core::Fail(core::ErrorCode::kFormat,
                          source + ":" + std::to_string(line_number) +
                              ": expected a header with the columns' names (or lines of eight: t x "
                              "y z qx qy qz qw)");
      } else {
        good = reader.Header(first, line_number);
      }
    } else {
      good = reader.Row(Fields(line, separator), line_number);
    }
    if (!good) return tl::unexpected(good.error());
  }
  if (reader.table.rows.empty()) {
    return core::Fail(core::ErrorCode::kFormat, source + ": no poses in it");
  }
  return std::move(reader.table);
}

}  // namespace kawara::survey
