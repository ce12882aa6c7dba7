#pragma once
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "core/expected.hpp"
#include "onboard/mapper/frame_source.hpp"
#include "onboard/mapper/model_builder.hpp"

namespace kawara::mapper {

/// What a model is made with.
struct ModelOptions {
  std::filesystem::path out = ".";
  PairOptions pairs;
  BuilderOptions builder;
  bool fresh = false;  ///< forget what an earlier run left in `out`
};

/// Answers to who waits for a model.
struct ModelHooks {
  /// How far it is: stops done, of all (0: nobody knows), pairs done. From the calling thread.
  std::function<void(std::uint64_t stops, std::uint64_t all, std::uint64_t pairs)> progress;
  /// A line that people should read: warnings, and what a run goes on from.
  std::function<void(const std::string&)> say;
  /// See ModelBuilder::OnMeasured; from the calling thread. If set, all pairs of the source are
  /// measured, those too that an earlier run has put into the model.
  Measured measured;
  /// See ModelBuilder::OnGrown; from the calling thread. An error ends the run.
  OnGrown grown;
  /// Called a few times a second while no pair comes: a robot that stands makes none. From the
  /// calling thread; may be empty.
  std::function<void()> waiting;
  /// Set by a signal: end soon, with everything durable.
  const std::atomic<bool>* stop = nullptr;
};

struct ModelResult {
  std::uint64_t pairs = 0;
  std::size_t tiles = 0;
  std::uint64_t faces = 0;
  double seconds = 0.0;
  bool interrupted = false;
  std::filesystem::path vrml;  ///< the whole model: a file that draws in those of the tiles
  /// Learnt of the rig by the refinement; empty if there was none.
  std::string rig;
};

/// The textured 3D model of a drive, on two threads: one reads pictures and refines poses, the
/// other matches, votes and writes tiles. `source_name` and the options are what a later run on the
/// same folder must have in common to go on where this one ends, however it ends. Errors: those of
/// the source and of the folder; kFormat: no pair at the baseline, or nothing to be measured.
core::Expected<ModelResult> RunModel(const ModelOptions& options, FrameSource& source,
                                     const std::string& source_name, const ModelHooks& hooks);

}  // namespace kawara::mapper
