#include "onboard/mapper/model_run.hpp"

#include <chrono>
#include <cstdio>
#include <thread>

#include "core/geodesy.hpp"
#include "onboard/mapper/pair_queue.hpp"

namespace kawara::mapper {
namespace {

/// All that changes the voxels.
std::string TextOf(const ModelOptions& options) {
  char text[280];
  std::snprintf(text, sizeof text,
                "baseline %.3f, step %.3f, poses %s, nearest %.2f, px-per-rad %.0f, voxel %.3f, "
                "reach %.1f, pole cap %.1f, method %s%s",
                options.pairs.baseline_m, options.pairs.step_m,
                options.pairs.refine ? "refined" : "given", options.builder.stereo.nearest_m,
                options.builder.stereo.px_per_rad, options.builder.voxel_m, options.builder.reach_m,
                options.builder.stereo.pole_cap_rad / core::kRadFromDeg,
                options.builder.stereo.method == StereoMethod::kPaper ? "paper" : "fast",
                options.pairs.several ? ", several baselines" : "");
  return text;
}

std::string TextOf(const vision::PoseRefiner& refiner) {
  const Eigen::Vector3d mounting = refiner.rig().mounting_rad / core::kRadFromDeg;
  const Eigen::Vector4d sd = refiner.rig_sd();
  char text[300];
  std::snprintf(text, sizeof text,
                "mounting off by %.3f %.3f %.3f deg (+- %.3f %.3f %.3f) about the body's axes, "
                "pictures %.1f ms (+- %.1f) after their stamps",
                mounting.x(), mounting.y(), mounting.z(), sd(0) / core::kRadFromDeg,
                sd(1) / core::kRadFromDeg, sd(2) / core::kRadFromDeg,
                1e3 * refiner.rig().time_offset_s, 1e3 * sd(3));
  return text;
}

/// The thread that reads and refines; ends when the source does, or the queue is closed.
core::Expected<void> MakePairs(FrameSource& source, PairMaker& maker, PairQueue& queue) {
  for (;;) {
    auto stop = source.Next();
    if (!stop) return tl::unexpected(stop.error());
    if (!*stop) break;
    auto pairs = maker.Add(**stop);
    if (!pairs) return tl::unexpected(pairs.error());
    for (PicturePair& pair : *pairs) {
      if (!queue.Push(std::move(pair))) return {};
    }
  }
  for (auto rest = maker.Finish(); !rest.empty(); rest = maker.Finish()) {
    for (PicturePair& pair : rest) {
      if (!queue.Push(std::move(pair))) return {};
    }
  }
  return {};
}

core::Expected<void> Consume(ModelBuilder& builder, PairQueue& queue, const FrameSource& source,
                             const ModelHooks& hooks, bool& interrupted) {
  const auto waiting = [&hooks] {
    if (hooks.waiting) hooks.waiting();
  };
  std::uint64_t thinned = 0;
  while (auto pair = queue.Pop(waiting)) {
    // Late: another baseline is worth less than another picture.
    if (source.live() && !pair->more.empty() && queue.full()) {
      pair->more.clear();
      if (++thinned == 1) {
        hooks.say("warning: late: some distance images are made with one baseline only");
      }
    }
    if (auto done = builder.Add(*pair); !done) return done;
    hooks.progress(pair->stop + 1, source.total(), builder.pairs());
    interrupted = hooks.stop != nullptr && *hooks.stop;
    if (interrupted) return {};
  }
  return {};
}

ModelResult ResultOf(const ModelBuilder& builder, std::chrono::steady_clock::time_point start) {
  ModelResult result;
  for (const TileRecord& tile : builder.store().manifest().tiles) {
    result.tiles += tile.faces > 0 ? 1 : 0;
    result.faces += tile.faces;
  }
  result.pairs = builder.pairs();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.vrml = builder.store().vrml();
  return result;
}

}  // namespace

core::Expected<ModelResult> RunModel(const ModelOptions& options, FrameSource& source,
                                     const std::string& source_name, const ModelHooks& hooks) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::unique_ptr<vision::StereoCamera>> cameras;
  for (const auto& camera : source.rig().cameras) {
    cameras.push_back(std::make_unique<vision::StereoCamera>(camera.model, camera.mask));
  }
  auto store = ModelStore::Open(options.out, {source_name, TextOf(options)}, source.rig().origin,
                                options.fresh);
  if (!store) return tl::unexpected(store.error());
  auto builder = ModelBuilder::Open(options.builder, source.rig(), cameras, std::move(*store));
  if (!builder) return tl::unexpected(builder.error());
  if (builder->damaged_records() > 0) {
    hooks.say("warning: " + std::to_string(builder->damaged_records()) + " damaged places in " +
              builder->store().voxels().string() + " were left out; --fresh makes all anew");
  }
  const std::uint64_t known = builder->store().manifest().stops_of_source;
  const bool complete = known > 0 && known == source.total();
  if (complete) {
    hooks.say("the model in " + options.out.string() +
              " is complete: " + (hooks.measured ? "only the report is made" : "nothing to do") +
              "; --fresh makes it anew");
    if (!hooks.measured) return ResultOf(*builder, start);
  } else if (builder->first_stop() > 0) {
    hooks.say("goes on with stop " + std::to_string(builder->first_stop() + 1) +
              " of the model in " + options.out.string());
  }

  if (hooks.measured) builder->OnMeasured(hooks.measured);
  if (hooks.grown) builder->OnGrown(hooks.grown);
  const std::uint64_t from_stop = hooks.measured ? 0 : builder->first_look();
  PairMaker maker(options.pairs, source.rig(), cameras, from_stop);
  PairQueue queue;
  core::Expected<void> made;
  std::thread reader([&] {
    made = MakePairs(source, maker, queue);
    queue.Close();
  });
  ModelResult result;
  const auto consumed = Consume(*builder, queue, source, hooks, result.interrupted);
  queue.Close();
  reader.join();
  // What is done stays done, whatever went wrong.
  const bool whole = consumed && made && !result.interrupted;
  if (builder->pairs() > 0 && !complete) {
    const auto ended = whole ? builder->Finish(source.total()) : builder->Pause();
    if (consumed && made && !ended) return tl::unexpected(ended.error());
  }
  if (!consumed) return tl::unexpected(consumed.error());
  if (!made) return tl::unexpected(made.error());
  if (maker.unreadable() > 0) {
    hooks.say("warning: " + std::to_string(maker.unreadable()) +
              " pictures were left out; the first: " + maker.first_unreadable());
  }
  if (builder->pairs() == 0 && !result.interrupted) {
    return core::Fail(core::ErrorCode::kFormat,
                      "no two frames of a camera in " + source_name + " are a baseline of " +
                          std::to_string(options.pairs.baseline_m) +
                          " m apart: take a longer survey, or a smaller --baseline");
  }
  const bool interrupted = result.interrupted;
  result = ResultOf(*builder, start);
  result.interrupted = interrupted;
  if (result.tiles == 0 && whole) {
    return core::Fail(core::ErrorCode::kFormat,
                      "nothing was measured often enough for a surface: check poses, mounting and "
                      "calibration with --depth-only");
  }
  if (maker.refiner() != nullptr && maker.refiner()->end() > 0)
    result.rig = TextOf(*maker.refiner());
  return result;
}

}  // namespace kawara::mapper
