#include "gis/track_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <optional>
#include <vector>

#include "gis/map_canvas.hpp"
#include "gis/map_view.hpp"
#include "gis/rows.hpp"
#include "gis/schema.hpp"
#include "gis/track_data.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector2d;

constexpr Colour kPaper{252, 252, 250};
constexpr Colour kGround{244, 244, 240};
constexpr Colour kInk{40, 40, 45};
constexpr Colour kFaint{110, 110, 115};
constexpr Colour kGrid{214, 214, 208};
constexpr Colour kWhite{255, 255, 255};
constexpr Colour kPicture{49, 54, 149};
constexpr Colour kStart{26, 120, 60};
constexpr Colour kEnd{180, 30, 40};
constexpr double kTextPx = 11.0;
constexpr double kSmallPx = 9.0;
constexpr double kPanelPx = 330.0;

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...) {
  std::array<char, 200> text{};
  std::va_list values;
  va_start(values, format);
  // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): version 14 does not see va_start here
  std::vsnprintf(text.data(), text.size(), format, values);
  va_end(values);
  return text.data();
}

/// 1, 2 or 5 times a power of ten, at least `least`.
double NiceStep(double least) {
  const double decade = std::pow(10.0, std::floor(std::log10(least)));
  for (const double step : {1.0, 2.0, 5.0})
    if (step * decade >= least) return step * decade;
  return 10.0 * decade;
}

std::string Signed(double m) { return m == 0.0 ? "0" : Format("%+g", m); }

std::string Metres(double m) {
  return m >= 1000.0 ? Format("%g km", m / 1000.0) : Format("%g m", m);
}

const Colour& ColourOf(core::RtkState state) {
  for (const RtkColour& c : kRtkColours)
    if (c.state == state) return c.colour;
  return kRtkColours.back().colour;
}

/// Metric grid: metres from the origin below and on the left, longitude above and latitude on the
/// right.
void DrawGrid(MapCanvas& canvas, const MapView& view) {
  canvas.Fill(view.from(), view.to(), kGround);
  constexpr double kLeastSpacingPx = 130.0;
  const double step = NiceStep(kLeastSpacingPx / view.px_per_m());
  const Vector2d low = view.LowEn();
  const Vector2d high = view.HighEn();
  const auto degrees = [](double rad, char positive, char negative) {
    const double deg = rad * core::kDegFromRad;
    return Format("%.5f%c", std::abs(deg), deg < 0 ? negative : positive);
  };
  const double middle_n = (low.y() + high.y()) / 2.0;
  const double middle_e = (low.x() + high.x()) / 2.0;
  for (long i = std::lround(std::ceil(low.x() / step)); static_cast<double>(i) * step <= high.x();
       ++i) {
    const double e = static_cast<double>(i) * step;
    const double x = view.Px(Vector2d(e, 0)).x();
    canvas.Line({x, view.from().y()}, {x, view.to().y()}, kGrid, i == 0 ? 1.4 : 0.8);
    canvas.Text({x, view.to().y() + 18}, Signed(e), kSmallPx, kFaint, Anchor::kCentre);
    const core::Geodetic g = view.plane().ToGeodetic({e, middle_n, 0});
    canvas.Text({x, view.from().y() - 8}, degrees(g.lon_rad, 'E', 'W'), kSmallPx, kFaint,
                Anchor::kCentre);
  }
  for (long i = std::lround(std::ceil(low.y() / step)); static_cast<double>(i) * step <= high.y();
       ++i) {
    const double n = static_cast<double>(i) * step;
    const double y = view.Px(Vector2d(0, n)).y();
    canvas.Line({view.from().x(), y}, {view.to().x(), y}, kGrid, i == 0 ? 1.4 : 0.8);
    canvas.Text({view.from().x() - 8, y + 4}, Signed(n), kSmallPx, kFaint, Anchor::kRight);
    const core::Geodetic g = view.plane().ToGeodetic({middle_e, n, 0});
    canvas.Text({view.to().x() + 8, y + 4}, degrees(g.lat_rad, 'N', 'S'), kSmallPx, kFaint);
  }
  canvas.Text({(view.from().x() + view.to().x()) / 2, view.to().y() + 36}, "metres east of start",
              kSmallPx, kFaint, Anchor::kCentre);
  canvas.Text({view.from().x() - 8, 22}, "m north", kSmallPx, kFaint, Anchor::kRight);
  canvas.Rectangle(view.from(), view.to(), kInk, 1.2);
}

void DrawTrack(MapCanvas& canvas, const MapView& view, const MissionTrack& track) {
  constexpr core::Duration kGap = core::Seconds(10);  // not known in between: a thin line only
  for (const double width : {6.0, 3.6}) {             // a white rim first
    for (std::size_t i = 1; i < track.poses.size(); ++i) {
      const TrackPoint& a = track.poses[i - 1];
      const TrackPoint& b = track.poses[i];
      const bool gap = b.time - a.time > kGap;
      const Colour colour = width > 5.0 ? kWhite : gap ? kFaint : ColourOf(b.rtk);
      canvas.Line(view.Px(a.position), view.Px(b.position), colour, gap ? width / 4.0 : width);
    }
  }
}

void DrawPictures(MapCanvas& canvas, const MapView& view, const MissionTrack& track) {
  constexpr double kLeastDistancePx = 13.0;
  std::optional<Vector2d> last;
  for (const PicturePoint& picture : track.pictures) {
    const Vector2d at = view.Px(picture.position);
    if (last && (at - *last).norm() < kLeastDistancePx) continue;
    last = at;
    const double yaw = picture.yaw_deg * core::kRadFromDeg;
    const Vector2d ahead(std::sin(yaw), -std::cos(yaw));
    canvas.Line(at, at + ahead * 12.0, kPicture, 1.8);
    canvas.Disc(at, 3.2, picture.full ? kPicture : kWhite, kPicture, 1.2);
  }
}

void DrawEnds(MapCanvas& canvas, const MapView& view, const MissionTrack& track) {
  if (track.poses.empty()) return;
  const Vector2d start = view.Px(track.poses.front().position);
  const Vector2d end = view.Px(track.poses.back().position);
  // The labels stand apart even when the robot came home.
  const bool start_above = start.y() < end.y();
  canvas.Disc(start, 7.0, kStart, kWhite, 2.0);
  canvas.Text(start + Vector2d(11, start_above ? -9 : 19), "start", kTextPx, kStart, Anchor::kLeft,
              true, true);
  canvas.Fill(end - Vector2d(7.5, 7.5), end + Vector2d(7.5, 7.5), kWhite);
  canvas.Fill(end - Vector2d(5.5, 5.5), end + Vector2d(5.5, 5.5), kEnd);
  canvas.Text(end + Vector2d(11, start_above ? 19 : -9), "end", kTextPx, kEnd, Anchor::kLeft, true,
              true);
}

void DrawStrokes(MapCanvas& canvas, const MapView& view, const MapOverlay& overlay) {
  for (const MapOverlay::Stroke& stroke : overlay.strokes)
    canvas.Line(view.Px(stroke.from), view.Px(stroke.to), stroke.colour,
                std::max(2.0, 0.4 * view.px_per_m()));
}

void DrawOutlines(MapCanvas& canvas, const MapView& view, const MapOverlay& overlay) {
  for (const MapOverlay::Outline& outline : overlay.outlines) {
    std::vector<Vector2d> ring;
    for (const core::Geodetic& g : outline.ring) ring.push_back(view.Px(g));
    canvas.Polygon(ring, outline.colour);
    for (std::size_t i = 0; i < ring.size(); ++i)
      canvas.Line(ring[i], ring[(i + 1) % ring.size()], kInk, 1.4);
  }
  std::vector<Vector2d> labels;  // each above those that it would lie on
  for (const MapOverlay::Outline& outline : overlay.outlines) {
    Vector2d top = view.Px(outline.ring.front());
    for (const core::Geodetic& g : outline.ring)
      if (const Vector2d at = view.Px(g); at.y() < top.y()) top = at;
    Vector2d at = top + Vector2d(0, -7);
    const double width_px = canvas.TextWidth(outline.label, kTextPx, true);
    const auto lies_on = [&](const Vector2d& other) {
      return std::abs(at.x() - other.x()) < width_px &&
             std::abs(at.y() - other.y()) < 1.3 * kTextPx;
    };
    while (std::any_of(labels.begin(), labels.end(), lies_on)) at.y() -= 1.4 * kTextPx;
    labels.push_back(at);
    if (at.y() < top.y() - kTextPx) canvas.Line(at + Vector2d(0, 3), top, kFaint, 1.0);
    canvas.Text(at, outline.label, kTextPx, kInk, Anchor::kCentre, true, true);
  }
}

void DrawScaleAndNorth(MapCanvas& canvas, const MapView& view) {
  const double length_m = NiceStep(90.0 / view.px_per_m());
  const double length_px = length_m * view.px_per_m();
  const Vector2d from(view.from().x() + 24, view.to().y() - 24);
  canvas.Fill(from - Vector2d(12, 32), from + Vector2d(length_px + 12, 12), kPaper);
  canvas.Rectangle(from - Vector2d(12, 32), from + Vector2d(length_px + 12, 12), kGrid, 1.0);
  canvas.Fill(from - Vector2d(0, 6), from + Vector2d(length_px, 0), kInk);
  canvas.Fill(from + Vector2d(length_px / 2, -5), from + Vector2d(length_px - 1, -1), kWhite);
  canvas.Text(from + Vector2d(length_px / 2, -13), Metres(length_m), kTextPx, kInk,
              Anchor::kCentre);
  const Vector2d tip(view.to().x() - 36, view.from().y() + 34);
  canvas.Fill(tip - Vector2d(22, 26), tip + Vector2d(22, 52), kPaper);
  canvas.Rectangle(tip - Vector2d(22, 26), tip + Vector2d(22, 52), kGrid, 1.0);
  canvas.Text(tip - Vector2d(0, 7), "N", kTextPx + 2, kInk, Anchor::kCentre, false, true);
  canvas.Polygon({tip, tip + Vector2d(-11, 42), tip + Vector2d(0, 32)}, kFaint);
  canvas.Polygon({tip, tip + Vector2d(11, 42), tip + Vector2d(0, 32)}, kInk);
}

/// Cut with ".." where it would leave the panel.
std::string Fitting(const MapCanvas& canvas, std::string text, double height_px, bool bold) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';  // the lettering is ASCII
  if (canvas.TextWidth(text, height_px, bold) <= kPanelPx) return text;
  while (!text.empty() && canvas.TextWidth(text + "..", height_px, bold) > kPanelPx)
    text.pop_back();
  return text + "..";
}

class Panel {
 public:
  Panel(MapCanvas& canvas, const Vector2d& at) : canvas_(canvas), at_(at) {}
  Vector2d at() const { return at_; }
  void Skip(double px) { at_.y() += px; }
  void Write(const std::string& text, double height_px = kTextPx, Colour colour = kInk,
             double indent_px = 0.0, bool bold = false) {
    canvas_.Text(at_ + Vector2d(indent_px, 0), Fitting(canvas_, text, height_px, bold), height_px,
                 colour, Anchor::kLeft, false, bold);
    at_.y() += height_px * 1.9;
  }

 private:
  MapCanvas& canvas_;
  Vector2d at_;
};

void WriteMission(Panel& panel, const MissionTrack& t) {
  panel.Write(t.robot, kTextPx + 3, kInk, 0, true);
  panel.Write("mission " + t.mission, kTextPx, kFaint);
  core::GpsTime first = t.poses.empty() ? t.pictures.front().time : t.poses.front().time;
  core::GpsTime last = t.poses.empty() ? t.pictures.back().time : t.poses.back().time;
  panel.Write(IsoUtc(UtcOf(first)).substr(0, 19) + " UTC");
  panel.Write(IsoUtc(UtcOf(last)).substr(0, 19) + " UTC");
  const auto full = std::count_if(t.pictures.begin(), t.pictures.end(),
                                  [](const PicturePoint& p) { return p.full; });
  panel.Write(Format("%.1f s, %.1f m", core::ToSeconds(last - first), t.length_m));
  panel.Write(
      Format("%zu poses, %zu pictures (%td full)", t.poses.size(), t.pictures.size(), full));
  panel.Skip(12);
}

void WriteLegend(MapCanvas& canvas, Panel& panel, const std::vector<MissionTrack>& tracks,
                 const MapOverlay& overlay, const core::Geodetic& origin) {
  std::size_t all = 0;
  for (const MissionTrack& t : tracks) all += t.poses.size();
  if (all > 0) panel.Write("position by", kTextPx, kFaint);
  for (const RtkColour& c : kRtkColours) {
    std::size_t n = 0;
    for (const MissionTrack& t : tracks)
      n += static_cast<std::size_t>(std::count_if(
          t.poses.begin(), t.poses.end(), [&c](const TrackPoint& p) { return p.rtk == c.state; }));
    if (n == 0) continue;
    canvas.Line(panel.at() + Vector2d(0, -4), panel.at() + Vector2d(28, -4), c.colour, 4.5);
    panel.Write(Format("%s  %.1f %%", core::ToString(c.state),
                       100.0 * static_cast<double>(n) / static_cast<double>(all)),
                kTextPx, kInk, 38);
  }
  panel.Skip(8);
  canvas.Line(panel.at() + Vector2d(10, -4), panel.at() + Vector2d(23, -4), kPicture, 1.8);
  canvas.Disc(panel.at() + Vector2d(10, -4), 3.2, kPicture, kPicture, 1.2);
  panel.Write("picture and heading", kTextPx, kInk, 38);
  panel.Skip(12);
  for (const MapOverlay::Legend& line : overlay.legend) {
    canvas.Line(panel.at() + Vector2d(0, -4), panel.at() + Vector2d(28, -4), line.colour, 8.0);
    panel.Write(line.text, kTextPx, kInk, 38);
  }
  if (!overlay.legend.empty()) panel.Skip(12);
  panel.Write("origin of the grid", kTextPx, kFaint);
  panel.Write(
      Format("%.8f, %.8f", origin.lat_rad * core::kDegFromRad, origin.lon_rad * core::kDegFromRad));
  panel.Write(Format("%.3f m above the ellipsoid, WGS 84", origin.h_ellipsoidal_m));
}

}  // namespace

core::Expected<void> DrawTrackMap(const std::string& store, const std::filesystem::path& png,
                                  const TrackMapOptions& options, const MapOverlay& overlay) {
  const auto tracks = LoadTracks(store);
  if (!tracks) return tl::unexpected(tracks.error());
  std::vector<core::Geodetic> places;
  for (auto t = tracks->rbegin(); t != tracks->rend(); ++t) {  // the newest gives the origin
    for (const TrackPoint& p : t->poses) places.push_back(p.position);
    for (const PicturePoint& p : t->pictures) places.push_back(p.position);
  }
  for (const MapOverlay::Outline& outline : overlay.outlines)
    places.insert(places.end(), outline.ring.begin(), outline.ring.end());
  for (const MapOverlay::Stroke& stroke : overlay.strokes) places.push_back(stroke.from);
  if (places.empty())
    return core::Fail(core::ErrorCode::kNotFound, "no map: the store holds no pose and no picture");
  const core::Geodetic origin = places.front();
  MapCanvas canvas(options.width_px, options.height_px, kPaper);
  const MapView view(places, origin, {72, 48},
                     {options.width_px - kPanelPx - 130.0, options.height_px - 64.0});
  DrawGrid(canvas, view);
  DrawStrokes(canvas, view, overlay);
  for (const MissionTrack& t : *tracks) DrawTrack(canvas, view, t);
  for (const MissionTrack& t : *tracks) DrawPictures(canvas, view, t);
  for (const MissionTrack& t : *tracks) DrawEnds(canvas, view, t);
  DrawOutlines(canvas, view, overlay);
  DrawScaleAndNorth(canvas, view);
  Panel panel(canvas, {options.width_px - kPanelPx - 14.0, 62});
  constexpr std::size_t kMostNamed = 4;
  for (std::size_t i = tracks->size() - std::min(tracks->size(), kMostNamed); i < tracks->size();
       ++i)
    WriteMission(panel, (*tracks)[i]);
  if (tracks->size() > kMostNamed)
    panel.Write(Format("and %zu more missions", tracks->size() - kMostNamed));
  WriteLegend(canvas, panel, *tracks, overlay, origin);
  return canvas.Save(png.string());
}

}  // namespace kawara::gis
