#include "onboard/survey/frame_matching.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <map>

namespace kawara::survey {
namespace {

namespace fs = std::filesystem;

bool IsNumber(const std::string& text) {
  return !text.empty() &&
         std::ranges::all_of(text, [](unsigned char c) { return c >= '0' && c <= '9'; });
}

/// "00042" and "42" are one name.
std::string Key(std::string text) {
  if (!IsNumber(text)) return text;
  const std::size_t first = text.find_first_not_of('0');
  return first == std::string::npos ? "0" : text.substr(first);
}

/// Numbers by their value, then texts.
bool Before(const fs::path& a, const fs::path& b) {
  const std::string x = Key(a.stem().string()), y = Key(b.stem().string());
  const bool nx = IsNumber(x), ny = IsNumber(y);
  if (nx != ny) return nx;
  if (nx && x.size() != y.size()) return x.size() < y.size();
  return x != y ? x < y : a < b;
}

bool IsPicture(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png";
}

/// How a row may name a picture: the path's end, the file's name, its stem.
std::string StemOf(const std::string& name) {
  const fs::path path(name);
  return Key(IsPicture(path) ? path.stem().string() : path.filename().string());
}

/// A stem that is a stamp: nanoseconds, or seconds with a fraction; in nanoseconds.
std::optional<std::int64_t> StampOf(const std::string& stem) {
  const std::size_t point = stem.find('.');
  std::string digits = stem.substr(0, point);
  if (!IsNumber(digits)) return {};
  if (point != std::string::npos) {
    std::string fraction = stem.substr(point + 1);
    if (!IsNumber(fraction)) return {};
    fraction.resize(9, '0');
    digits += fraction;
  }
  if (digits.size() > 19 || (digits.size() == 19 && digits > "9223372036854775807")) return {};
  return std::stoll(digits);
}

/// Stamps within a millisecond of the pictures' names.
std::optional<std::vector<int>> ByStamp(const std::vector<PoseRow>& rows, const std::string& camera,
                                        const std::vector<fs::path>& pictures) {
  constexpr std::int64_t kNear = 1'000'000;
  std::map<std::int64_t, int> at;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto stamp = StampOf(pictures[i].stem().string());
    if (!stamp) return {};
    at.emplace(*stamp, static_cast<int>(i));
  }
  std::vector<int> found(rows.size(), -1);
  bool any = false;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (!rows[r].time.IsSet() || (!rows[r].camera.empty() && rows[r].camera != camera)) continue;
    const std::int64_t t = rows[r].time.ns();
    auto next = at.lower_bound(t);
    if (next != at.begin() && (next == at.end() || next->first - t > t - std::prev(next)->first)) {
      --next;
    }
    if (next == at.end() || next->first > t + kNear || next->first < t - kNear) continue;
    found[r] = next->second;
    any = true;
  }
  if (!any) return {};
  return found;
}

}  // namespace

core::Expected<std::vector<fs::path>> ListPictures(const fs::path& where) {
  const bool pattern = where.filename().string().find_first_of("*?") != std::string::npos;
  const fs::path folder = pattern ? where.parent_path() : where;
  std::error_code error;
  std::vector<fs::path> pictures;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!IsPicture(it->path()) || name.starts_with('.')) continue;  // "._7.jpg" is no picture
    if (pattern && ::fnmatch(where.filename().c_str(), name.c_str(), FNM_PERIOD) != 0) continue;
    pictures.push_back(it->path());
  }
  if (error) {
    return core::Fail(core::ErrorCode::kNotFound, folder.string() + ": " + error.message());
  }
  if (pictures.empty()) {
    return core::Fail(core::ErrorCode::kNotFound,
                      where.string() + ": no .jpg, .jpeg or .png pictures");
  }
  std::ranges::sort(pictures, Before);
  return pictures;
}

core::Expected<std::vector<int>> MatchPictures(const std::vector<PoseRow>& rows,
                                               const std::string& camera,
                                               const std::vector<fs::path>& pictures) {
  const auto is_ours = [&](const PoseRow& row) {
    return row.camera.empty() || row.camera == camera;
  };
  std::vector<int> found(rows.size(), -1);
  if (std::ranges::any_of(rows, [](const PoseRow& row) { return !row.name.empty(); })) {
    std::map<std::string, int> by_stem;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      by_stem.emplace(Key(pictures[i].stem().string()), static_cast<int>(i));
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows[r].name.empty() || !is_ours(rows[r])) continue;
      const auto at = by_stem.find(StemOf(rows[r].name));
      if (at == by_stem.end()) continue;
      // "left/7.png" is not the right camera's 7.png.
      const fs::path folder = fs::path(rows[r].name).parent_path().filename();
      const fs::path& picture = pictures[static_cast<std::size_t>(at->second)];
      if (!folder.empty() && folder != picture.parent_path().filename()) continue;
      found[r] = at->second;
    }
    return found;
  }
  if (auto by_stamp = ByStamp(rows, camera, pictures)) return *by_stamp;
  const auto ours = std::ranges::count_if(rows, is_ours);
  if (static_cast<std::size_t>(ours) != pictures.size()) {
    return core::Fail(core::ErrorCode::kFormat,
                      std::to_string(ours) + " poses and " + std::to_string(pictures.size()) +
                          " pictures in " + pictures.front().parent_path().string() +
                          ": name them in a column 'frame' or 'file', or have as many of both");
  }
  int next = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (is_ours(rows[r])) found[r] = next++;
  }
  return found;
}

}  // namespace kawara::survey
