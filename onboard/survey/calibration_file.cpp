#include "onboard/survey/calibration_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "onboard/survey/calibration_formats.hpp"

namespace kawara::survey {
namespace {

/// OpenCV writes "%YAML:1.0" and "!!opencv-matrix", which are no YAML of today. Blanked out, so
/// that lines and columns stay.
std::string WithoutOpenCvMarks(std::string_view text) {
  std::string plain(text);
  if (plain.starts_with("%YAML")) {
    for (std::size_t i = 0; i < plain.size() && plain[i] != '\n'; ++i) plain[i] = ' ';
  }
  constexpr std::string_view kTag = "!!opencv-matrix";
  for (std::size_t at = plain.find(kTag); at != std::string::npos; at = plain.find(kTag, at)) {
    plain.replace(at, kTag.size(), kTag.size(), ' ');
  }
  return plain;
}

/// The first thing that is no comment is a number.
bool LooksLikeOcam(std::string_view text) {
  while (!text.empty()) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return false;
    text.remove_prefix(first);
    if (text.front() != '#') return text.front() >= '0' && text.front() <= '9';
    text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
  return false;
}

}  // namespace

bool SetSize(vision::CameraChoice& optics, double width_px, double height_px) {
  const auto good = [](double px) { return px >= 2 && px <= 65500 && px == std::floor(px); };
  if (!good(width_px) || !good(height_px)) return false;
  const auto set = [&](auto& lens) {
    lens.common.width_px = static_cast<int>(width_px);
    lens.common.height_px = static_cast<int>(height_px);
  };
  set(optics.equidistant);
  set(optics.kb4);
  set(optics.ocam);
  set(optics.mei);
  set(optics.eucm);
  set(optics.double_sphere);
  return true;
}

core::Expected<std::vector<Calibration>> ParseCalibration(std::string_view text,
                                                          const std::string& source,
                                                          OpenCvModel opencv) {
  if (text.substr(0, 200).find("<?xml") != std::string_view::npos) {
    return core::Fail(core::ErrorCode::kFormat,
                      source + ": XML is not read here: let OpenCV write it as .yaml or .json");
  }
  if (LooksLikeOcam(text)) return ParseOcam(text, source);
  core::config::Problems problems;
  const Node root = core::config::ParseYaml(WithoutOpenCvMarks(text), source, problems);
  if (!problems.empty()) return core::Fail(core::ErrorCode::kFormat, problems.Text());
  if (root.kind == Node::Kind::kMap) {
    if (root.Find("cam0") != nullptr) return ParseKalibr(root);
    if (const Node* value = root.Find("value0"); value != nullptr) return ParseBasalt(*value);
    if (root.Find("camera_matrix") != nullptr || root.Find("K") != nullptr) {
      return ParseOpenCv(root, opencv);
    }
  }
  return core::Fail(core::ErrorCode::kFormat,
                    source +
                        ": not a calibration known here: expected OCamCalib's "
                        "calib_results.txt, Kalibr's camchain (cam0: ...), Basalt's json "
                        "(value0: ...) or OpenCV's yaml (camera_matrix: or K:)");
}

// Numbers in a fixed order between comments: direct polynomial, inverse polynomial (each with its
// length first), centre row and column, affine c d e, height and width.
Calibrations ParseOcam(std::string_view text, const std::string& source) {
  const auto wrong = [&](int line, const std::string& what) {
    return core::Fail(core::ErrorCode::kFormat,
                      source + ":" + std::to_string(line) + ":1: calib_results.txt: " + what);
  };
  std::vector<double> numbers;
  int line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = text.find('\n');
    std::istringstream words{std::string(text.substr(0, std::min(end, text.find('#'))))};
    for (std::string word; words >> word;) {
      double value = 0.0;
      const char* const last = word.data() + word.size();
      const auto [stop, error] = std::from_chars(word.data(), last, value);
      if (error != std::errc() || stop != last || !std::isfinite(value) || numbers.size() > 200) {
        return wrong(line_number, "'" + word.substr(0, 20) + "': expected a number");
      }
      numbers.push_back(value);
    }
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  constexpr std::size_t kTail = 7;
  const auto length = [&](std::size_t at) -> std::size_t {
    const bool good = at < numbers.size() && numbers[at] >= 1 && numbers[at] <= 32 &&
                      numbers[at] == std::floor(numbers[at]);
    return good ? static_cast<std::size_t>(numbers[at]) : 0;
  };
  const std::size_t direct = length(0);
  std::size_t tail = 1 + direct;
  if (direct == 0 || numbers.size() < tail + kTail) {
    return wrong(line_number,
                 "expected the direct polynomial, the inverse one, centre, affine "
                 "parameters c d e, height and width");
  }
  if (numbers.size() != tail + kTail) tail += 1 + length(tail);
  if (numbers.size() != tail + kTail) {
    return wrong(line_number, "expected " + std::to_string(tail + kTail) +
                                  " numbers by the lengths of its polynomials, found " +
                                  std::to_string(numbers.size()));
  }
  Calibration made;
  made.optics.camera = "ocam";
  vision::OcamParameters& ocam = made.optics.ocam;
  ocam.polynomial.assign(numbers.begin() + 1, numbers.begin() + 1 + static_cast<long>(direct));
  ocam.common.center_v_px = numbers[tail];
  ocam.common.center_u_px = numbers[tail + 1];
  ocam.affine_c = numbers[tail + 2];
  ocam.affine_d = numbers[tail + 3];
  ocam.affine_e = numbers[tail + 4];
  if (!SetSize(made.optics, numbers[tail + 6], numbers[tail + 5])) {
    return wrong(line_number, "height and width: expected whole numbers 2..65500");
  }
  return std::vector{made};
}

}  // namespace kawara::survey
