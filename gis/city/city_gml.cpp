#include "gis/city/city_gml.hpp"

#include <expat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

namespace kawara::gis {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kDeepest = 256;
constexpr int kHighestBuildingLod = 3;  // above it are rooms

/// "gml:posList" -> "posList".
std::string_view LocalName(std::string_view name) { return name.substr(name.rfind(':') + 1); }

class Parser {
 public:
  Parser(const MapFrame& frame, CityGmlTheme theme) : frame_(frame), theme_(theme) {}

  void Start(std::string_view name, const char* const* attributes) {
    if (error_) return;
    const std::string_view local = LocalName(name);
    if (stack_.size() >= kDeepest) return Fail("nested too deep");
    stack_.emplace_back(local);
    for (; *attributes != nullptr && *(attributes + 1) != nullptr; attributes += 2) {
      const std::string_view key = LocalName(*attributes), value = attributes[1];
      if (key == "srsName") TakeReferenceSystem(std::string(value));
      if (key == "srsDimension") dimension_ = value == "2" ? 2 : 3;
      if (key == "id" && object_depth_ == 0 && IsObject(local)) object_.name = value;
    }
    if (object_depth_ == 0) {
      if (IsObject(local)) object_depth_ = stack_.size();
      return;
    }
    if (local.size() > 4 && local.starts_with("lod") && local[3] >= '0' && local[3] <= '9')
      lods_.emplace_back(stack_.size(), local[3] - '0');
    if (local == "Polygon" || local == "Triangle" || local == "Rectangle") surface_ = {};
    if (local == "LinearRing") ring_.clear();
    wants_text_ = local == "posList" || local == "pos" || local == "creationDate" ||
                  local == "surveyYear" || (local == "name" && stack_.size() == object_depth_ + 1);
    text_.clear();
  }

  void Text(std::string_view text) {
    if (wants_text_) text_ += text;
  }

  void End() {
    if (error_) return;
    const std::string local = stack_.back();
    if (object_depth_ != 0) TakeEnd(local);
    if (!lods_.empty() && lods_.back().first == stack_.size()) lods_.pop_back();
    if (object_depth_ == stack_.size()) FinishObject();
    stack_.pop_back();
    wants_text_ = false;
  }

  const std::optional<core::Error>& error() const { return error_; }
  CityObjects Take() {
    if (axes_) objects_.heights = axes_->heights();
    return std::move(objects_);
  }

 private:
  void Fail(const std::string& what, core::ErrorCode code = core::ErrorCode::kFormat) {
    if (!error_) error_ = core::Error{code, what};
  }
  bool IsObject(std::string_view local) const {
    return local == (theme_ == CityGmlTheme::kRoads ? "Road" : "Building");
  }

  void TakeReferenceSystem(const std::string& name) {
    if (name.empty() || name == reference_system_) return;
    if (!reference_system_.empty() && axes_)
      return Fail("two reference systems, " + reference_system_ + " and " + name);
    reference_system_ = name;
  }

  void TakeEnd(const std::string& local) {
    if (local == "posList" || local == "pos") {
      TakePositions();
    } else if (local == "LinearRing") {
      const bool is_hole = std::find(stack_.begin(), stack_.end(), "interior") != stack_.end();
      if (is_hole) {
        surface_.holes_m.push_back(std::move(ring_));
      } else {
        surface_.outer_m = std::move(ring_);
      }
      ring_.clear();
    } else if (local == "Polygon" || local == "Triangle" || local == "Rectangle") {
      const bool is_real =
          std::find(stack_.begin(), stack_.end(), "ClosureSurface") == stack_.end();
      if (is_real && !lods_.empty() && surface_.outer_m.size() >= 3)
        by_lod_[lods_.back().second].push_back(std::move(surface_));
      surface_ = {};
    } else if (local == "creationDate" && !object_.date) {
      object_.date = DateOf(text_);
    } else if (local == "surveyYear") {
      if (const auto date = DateOf(text_)) object_.date = date;
    } else if (local == "name" && stack_.size() == object_depth_ + 1 && !text_.empty()) {
      object_.name = text_;
    }
  }

  void TakePositions() {
    numbers_.clear();
    const char* at = text_.data();
    const char* const end = at + text_.size();
    while (true) {
      while (at != end && std::strchr(" \t\r\n", *at) != nullptr) ++at;
      if (at == end) break;
      double value = 0.0;
      const auto [stop, bad] = std::from_chars(*at == '+' ? at + 1 : at, end, value);
      if (bad != std::errc()) return Fail("a coordinate that is no number");
      numbers_.push_back(value);
      at = stop;
    }
    // Some files state no dimension, and are flat all the same.
    const std::size_t dimension = dimension_ == 3 && numbers_.size() % 3 != 0 ? 2 : dimension_;
    if (numbers_.size() % dimension != 0) return Fail("a list of positions with a number too many");
    if (!axes_) {
      auto made = CityAxes::Make(reference_system_, frame_);
      if (!made) return Fail(made.error().message, made.error().code);
      axes_.emplace(std::move(*made));
    }
    for (std::size_t i = 0; i + dimension <= numbers_.size(); i += dimension)
      ring_.push_back(
          axes_->Place({numbers_[i], numbers_[i + 1], dimension == 3 ? numbers_[i + 2] : 0.0}));
  }

  void FinishObject() {
    object_depth_ = 0;
    lods_.clear();
    if (theme_ == CityGmlTheme::kBuildings) {
      by_lod_.erase(0);
      by_lod_.erase(by_lod_.upper_bound(kHighestBuildingLod), by_lod_.end());
    }
    if (by_lod_.empty()) {
      ++objects_.passed_over;
    } else {
      auto& [lod, surfaces] = theme_ == CityGmlTheme::kRoads ? *by_lod_.begin() : *by_lod_.rbegin();
      object_.lod = lod;
      object_.surfaces = std::move(surfaces);
      objects_.objects.push_back(std::move(object_));
    }
    object_ = {};
    by_lod_.clear();
  }

  const MapFrame& frame_;
  const CityGmlTheme theme_;
  std::optional<core::Error> error_;
  std::vector<std::string> stack_;  ///< local names of the open elements
  std::string reference_system_;
  std::size_t dimension_ = 3;
  std::optional<CityAxes> axes_;
  CityObjects objects_;

  std::size_t object_depth_ = 0;  ///< of stack_; 0: outside any
  CityObject object_;
  std::map<int, std::vector<CitySurface>> by_lod_;
  std::vector<std::pair<std::size_t, int>> lods_;  ///< depth of stack_, level
  CitySurface surface_;
  std::vector<Vector3d> ring_;
  std::string text_;
  std::vector<double> numbers_;
  bool wants_text_ = false;
};

struct FreeExpat {
  void operator()(XML_ParserStruct* parser) const { XML_ParserFree(parser); }
};

void XMLCALL OnStart(void* user, const XML_Char* name, const XML_Char** attributes) {
  static_cast<Parser*>(user)->Start(name, attributes);
}
void XMLCALL OnEnd(void* user, const XML_Char* /*name*/) { static_cast<Parser*>(user)->End(); }
void XMLCALL OnText(void* user, const XML_Char* text, int size) {
  static_cast<Parser*>(user)->Text({text, static_cast<std::size_t>(size)});
}

}  // namespace

core::Expected<CityObjects> ReadCityGml(const std::string& path, const MapFrame& frame,
                                        CityGmlTheme theme) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return tl::unexpected(core::ErrnoError(path, errno == 0 ? EIO : errno));
  Parser parser(frame, theme);
  const std::unique_ptr<XML_ParserStruct, FreeExpat> expat(XML_ParserCreate(nullptr));
  XML_SetUserData(expat.get(), &parser);
  XML_SetElementHandler(expat.get(), OnStart, OnEnd);
  XML_SetCharacterDataHandler(expat.get(), OnText);
  std::array<char, 65'536> buffer{};
  bool is_last = false;
  while (!is_last) {
    file.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    is_last = !file;
    const auto parsed =
        XML_Parse(expat.get(), buffer.data(), static_cast<int>(file.gcount()), is_last ? 1 : 0);
    const std::string place =
        path + ": line " + std::to_string(XML_GetCurrentLineNumber(expat.get())) + ": ";
    if (parser.error())
      return core::Fail(parser.error()->code,
                        (parser.error()->code == core::ErrorCode::kFormat ? place : path + ": ") +
                            parser.error()->message);
    if (parsed == XML_STATUS_ERROR)
      return core::Fail(core::ErrorCode::kFormat,
                        place + XML_ErrorString(XML_GetErrorCode(expat.get())));
  }
  return parser.Take();
}

}  // namespace kawara::gis
