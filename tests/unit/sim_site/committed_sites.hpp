#pragma once
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <string>

#include "sim/site/scene_builder.hpp"
#include "sim/site/site_config.hpp"

namespace kawara::sim {

inline constexpr std::array kCommittedSites{"factory_road", "residential_collapse",
                                            "warehouse_yard"};

inline std::string SitePath(const std::string& name) {
  return std::string(KAWARA_SOURCE_DIR) + "/configs/sites/" + name + ".yaml";
}

inline SiteConfig LoadCommitted(const std::string& name) {
  auto site = LoadSite(SitePath(name));
  if (!site) ADD_FAILURE() << site.error().message;
  return site.value_or(SiteConfig{});
}

struct BuiltSite {
  SiteConfig site;
  Scene before;
  Scene after;
};

/// Built once a process.
inline const BuiltSite& Built(const std::string& name) {
  static std::map<std::string, BuiltSite> built;
  const auto found = built.find(name);
  if (found != built.end()) return found->second;
  const SiteConfig site = LoadCommitted(name);
  return built[name] = {site, BuildScene(site, SiteState::kBefore),
                        BuildScene(site, SiteState::kAfter)};
}

/// Road and terrain only, no thing on it.
inline SiteConfig EmptySite() {
  SiteConfig site;
  site.name = "empty";
  site.terrain.west_m = -40;
  site.terrain.east_m = 40;
  site.terrain.south_m = -30;
  site.terrain.north_m = 30;
  site.road.points_m = {{-35, 0}, {35, 0}};
  site.path.points = {{{-30, 0}, {}}, {{30, 0}, {}}};
  return site;
}

}  // namespace kawara::sim
