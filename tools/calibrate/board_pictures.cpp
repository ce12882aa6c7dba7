#include "tools/calibrate/board_pictures.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>

#include "onboard/survey/picture_file.hpp"

namespace kawara::calibrate {
namespace {

namespace fs = std::filesystem;
using core::ErrorCode;
using core::Fail;

/// Names in a message; the rest is counted.
constexpr std::size_t kMostNames = 5;

bool IsPicture(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png";
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMostNames, names.size()); ++i) {
    text += (i > 0 ? ", " : "") + names[i];
  }
  if (names.size() > kMostNames) {
    text += " and " + std::to_string(names.size() - kMostNames) + " more";
  }
  return text;
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

core::Expected<std::vector<fs::path>> PicturesIn(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder, error);
  if (error) {
    return Fail(ErrorCode::kNotFound, folder.string() + ": " + error.message() +
                                          " (expected a folder of pictures of the board)");
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : entries) {
    if (entry.is_regular_file(error) && IsPicture(entry.path())) files.push_back(entry.path());
  }
  if (files.empty()) {
    return Fail(ErrorCode::kNotFound,
                folder.string() +
                    ": no pictures in it (.jpg, .jpeg, .png); take 20 to 40 with the "
                    "board near and all around the camera");
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

core::Expected<BoardPictures> FindBoards(const fs::path& folder, const vision::Board& board) {
  const auto files = PicturesIn(folder);
  if (!files) return tl::unexpected(files.error());
  BoardPictures found;
  std::vector<std::string> without;
  std::map<std::pair<int, int>, int> others;  // lattices that are no part of the board
  for (const fs::path& file : *files) {
    const auto picture = survey::LoadPicture(file);
    if (!picture) {
      found.warnings.push_back("left out: " + picture.error().message);
      continue;
    }
    if (found.pictures == 0) {
      found.width_px = picture->width_px;
      found.height_px = picture->height_px;
    } else if (picture->width_px != found.width_px || picture->height_px != found.height_px) {
      found.warnings.push_back(
          "left out: " + file.string() + " has " + SizeText(picture->width_px, picture->height_px) +
          " px, the first picture " + SizeText(found.width_px, found.height_px));
      continue;
    }
    ++found.pictures;
    found.brightest.Add(picture->view());
    vision::FoundBoard seen = vision::FindBoard(picture->view(), board);
    if (!seen.view.empty() && !seen.Fits(board)) {
      ++others[std::minmax(seen.cols, seen.rows)];
      seen.view.clear();
    }
    if (seen.view.empty()) {
      without.push_back(file.filename().string());
      continue;
    }
    found.corners += seen.view.size();
    found.names.push_back(file.filename().string());
    found.views.push_back(std::move(seen.view));
  }
  if (found.pictures == 0) {
    return Fail(ErrorCode::kFormat, folder.string() + ": none of " + std::to_string(files->size()) +
                                        " pictures can be read; " + found.warnings.front());
  }
  std::string other;
  if (!others.empty()) {
    const auto most =
        std::ranges::max_element(others, {}, [](const auto& lattice) { return lattice.second; });
    other = "; " + std::to_string(most->second) + " show one of " +
            SizeText(most->first.second, most->first.first) +
            " inner corners instead: --board counts where four squares meet, not squares";
  }
  const std::string name = SizeText(board.cols, board.rows);
  if (found.views.empty()) {
    return Fail(ErrorCode::kFormat,
                folder.string() + ": no board of " + name + " inner corners in any of " +
                    std::to_string(found.pictures) + " pictures (" + Listed(without) + ")" +
                    (other.empty() ? ": is it sharp, evenly lit, whole but for a few squares, and "
                                     "its squares 8 px wide or more?"
                                   : other));
  }
  if (!without.empty()) {
    found.warnings.push_back(
        "no board of " + name + " inner corners in " + std::to_string(without.size()) + " of " +
        std::to_string(found.pictures) + " pictures: " + Listed(without) + other);
  }
  return found;
}

}  // namespace kawara::calibrate
