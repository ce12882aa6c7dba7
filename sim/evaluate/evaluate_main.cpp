#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "sim/evaluate/cloud_errors.hpp"
#include "sim/evaluate/object_errors.hpp"
#include "sim/evaluate/ply_cloud.hpp"
#include "sim/evaluate/pose_errors.hpp"
#include "sim/evaluate/range_errors.hpp"

namespace {

namespace fs = std::filesystem;
using kawara::core::Error;
using kawara::core::Expected;
using kawara::sim::ErrorReport;

struct Arguments {
  std::string truth;
  std::string result;
  std::string json;
  std::string histogram;
  double voxel_m = 0.1;
  double max_distance_m = 2.0;
  double max_gap_s = 0.5;
};

Expected<void> WriteFile(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.flush();
  if (file) return {};
  return kawara::core::Fail(kawara::core::ErrorCode::kIo, path + ": cannot be written");
}

Expected<ErrorReport> Poses(const Arguments& a) {
  const auto truth = kawara::sim::ReadPoses(a.truth);
  if (!truth) return tl::unexpected(truth.error());
  const auto result = kawara::sim::ReadPoses(a.result);
  if (!result) return tl::unexpected(result.error());
  return kawara::sim::ComparePoses(*truth, *result, a.max_gap_s);
}

/// The range images of a folder by the name they have in common, or the one that is no folder.
std::set<std::string> Names(const std::string& path) {
  std::set<std::string> names;
  if (!fs::is_directory(path)) return {""};
  for (const auto& entry : fs::directory_iterator(path)) {
    const std::string extension = entry.path().extension();
    if (extension == ".png" || extension == ".pfm" || extension == ".tiff") {
      names.insert(entry.path().stem());
    }
  }
  return names;
}

std::string FileOf(const std::string& path, const std::string& name) {
  if (name.empty()) return path;
  for (const char* extension : {".pfm", ".tiff", ".png"}) {
    if (const fs::path file = fs::path(path) / (name + extension); fs::exists(file)) return file;
  }
  return (fs::path(path) / name).string();
}

Expected<ErrorReport> Ranges(const Arguments& a) {
  kawara::sim::RangeErrors errors;
  int pictures = 0;
  const std::set<std::string> in_truth = Names(a.truth);
  for (const std::string& name : Names(a.result)) {
    if (!name.empty() && !in_truth.contains(name)) continue;
    const auto truth = kawara::sim::ReadRangeImage(FileOf(a.truth, name));
    if (!truth) return tl::unexpected(truth.error());
    const auto result = kawara::sim::ReadRangeImage(FileOf(a.result, name));
    if (!result) return tl::unexpected(result.error());
    if (auto added = errors.Add(*truth, *result); !added) {
      return tl::unexpected(Error{added.error().code, name + ": " + added.error().message});
    }
    ++pictures;
  }
  if (pictures == 0) {
    return kawara::core::Fail(kawara::core::ErrorCode::kNotFound,
                              a.result + ": no range image of a name that " + a.truth + " has");
  }
  if (!a.histogram.empty()) {
    if (auto done = WriteFile(a.histogram, errors.HistogramCsv()); !done) {
      return tl::unexpected(done.error());
    }
  }
  return errors.Report();
}

Expected<ErrorReport> Cloud(const Arguments& a) {
  const auto truth = kawara::sim::ReadCloudPoints(a.truth);
  if (!truth) return tl::unexpected(truth.error());
  const auto result = kawara::sim::ReadCloudPoints(a.result);
  if (!result) return tl::unexpected(result.error());
  return kawara::sim::CompareClouds(*truth, *result, a.voxel_m);
}

Expected<ErrorReport> Objects(const Arguments& a) {
  const auto place = kawara::sim::PlaceOfBoxes(a.truth);
  if (!place) return tl::unexpected(place.error());
  const kawara::core::LocalEnu plane(*place);
  const auto truth = kawara::sim::ReadBoxes(a.truth, plane);
  if (!truth) return tl::unexpected(truth.error());
  const auto result = kawara::sim::ReadBoxes(a.result, plane);
  if (!result) return tl::unexpected(result.error());
  std::printf("%s\n", kawara::sim::ListObjects(*truth, *result, a.max_distance_m).c_str());
  return kawara::sim::CompareObjects(*truth, *result, a.max_distance_m);
}

int Tell(const Expected<ErrorReport>& report, const Arguments& a) {
  Expected<void> written;
  if (report && !a.json.empty()) written = WriteFile(a.json, report->Json() + "\n");
  if (!report || !written) {
    const Error& error = report ? written.error() : report.error();
    std::fprintf(stderr, "kawara-evaluate: %s\n", error.message.c_str());
    return 2;
  }
  std::printf("%s", report->Text().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How far results are from the truth. Prints a table of the errors.");
  app.require_subcommand(1);
  Arguments a;
  const auto add = [&](const char* name, const char* what) {
    CLI::App* command = app.add_subcommand(name, what);
    command->add_option("--truth", a.truth, "what was")->required();
    command->add_option("--result", a.result, "what was said of it")->required();
    command->add_option("--json", a.json, "the same figures for programs, into this file");
    return command;
  };
  CLI::App* poses = add("poses", "trajectories: CSV (also kawara-log export), or a store");
  poses->add_option("--max-gap", a.max_gap_s, "between rows of the truth [s]")
      ->capture_default_str();
  CLI::App* ranges = add("ranges", "range images of equal names in two folders, or two files");
  ranges->add_option("--histogram", a.histogram, "CSV of the errors within 2..6 m");
  CLI::App* cloud = add("cloud", "points on surfaces: two PLY or LAS files in the same axes");
  cloud->add_option("--voxel", a.voxel_m, "size of the voxels that are counted [m]")
      ->check(CLI::Range(0.001, 100.0))
      ->capture_default_str();
  CLI::App* objects = add("objects", "boxes with eight apexes: CSV or GeoPackage");
  objects->add_option("--max-distance", a.max_distance_m, "between centres of the same object [m]")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (poses->parsed()) return Tell(Poses(a), a);
  if (ranges->parsed()) return Tell(Ranges(a), a);
  if (cloud->parsed()) return Tell(Cloud(a), a);
  return Tell(Objects(a), a);
}
