#include "station/store_feeder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <utility>

namespace kawara::station {
namespace {

constexpr std::size_t kMostLatencies = 100000;
constexpr std::size_t kMostObjects = 20000;  // waiting for a register that cannot be written

core::Expected<void> Add(gis::SpatioTemporalStore& store, const Item& item) {
  if (const auto* pose = std::get_if<gis::PoseRecord>(&item.record)) return store.AddPose(*pose);
  if (const auto* event = std::get_if<gis::EventRecord>(&item.record))
    return store.AddEvent(*event);
  return store.AddPanorama(*item.picture());
}

core::Expected<void> Add(ObjectFeeder& objects, const Item& item) {
  if (const auto* object = std::get_if<comms::ObjectReport>(&item.record))
    return objects.Add(*object);
  if (const auto* texture = std::get_if<comms::TextureReport>(&item.record))
    return objects.Add(*texture);
  return objects.Add(std::get<comms::RoadReport>(item.record));
}

}  // namespace

StoreFeeder::StoreFeeder(gis::StoreConfig config, Say say)
    : config_(std::move(config)), say_(std::move(say)), objects_(config_.target) {}

core::Expected<StoreFeeder> StoreFeeder::Create(gis::StoreConfig config,
                                                const std::string& latency_csv, Say say) {
  StoreFeeder feeder(std::move(config), std::move(say));
  if (!latency_csv.empty()) {
    feeder.csv_.reset(std::fopen(latency_csv.c_str(), "we"));
    if (!feeder.csv_) return tl::unexpected(core::ErrnoError("create " + latency_csv, errno));
    std::fputs("epoch,gps_ns,stage,mono_ns,received_mono_ns\n", feeder.csv_.get());
  }
  return feeder;
}

core::Expected<void> StoreFeeder::Connect() {
  if (store_) return {};
  auto store = gis::SpatioTemporalStore::Open(config_);
  if (!store) return tl::unexpected(store.error());
  store_.emplace(std::move(*store));
  return {};
}

void StoreFeeder::Put(Item item) {
  if (item.is_of_objects()) {
    pending_objects_.push_back(std::move(item));
    if (pending_objects_.size() <= kMostObjects) return;
    pending_objects_.pop_front();
    ++refused_;
    return;
  }
  if (item.picture() != nullptr) ++pending_pictures_;
  pending_.push_back(std::move(item));
}

void StoreFeeder::Report(const core::Expected<void>& result) {
  if (result && !trouble_.empty()) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(),
                  "store works again after %.1f s, %zu records were kept waiting",
                  core::ToSeconds(core::MonoNow() - trouble_since_), pending_.size());
    say_(text.data());
    trouble_.clear();
  } else if (!result && trouble_ != result.error().message) {
    if (trouble_.empty()) trouble_since_ = core::MonoNow();
    trouble_ = result.error().message;
    say_(trouble_ + "; nothing is lost, trying again");
  }
}

core::Expected<void> StoreFeeder::Attempt(bool finish) {
  if (auto connected = Connect(); !connected) return connected;
  for (; handed_ < pending_.size(); ++handed_) {
    auto added = Add(*store_, pending_[handed_]);
    if (added) continue;
    if (added.error().code != core::ErrorCode::kInvalidArgument) return added;
    ++refused_;  // the store checks again what the intake has checked
  }
  return finish ? store_->Close() : store_->Flush();
}

core::Expected<void> StoreFeeder::RegisterObjects(bool finish) {
  core::Expected<void> done;
  while (done && !pending_objects_.empty()) {
    done = Add(objects_, pending_objects_.front());
    if (!done && done.error().code != core::ErrorCode::kInvalidArgument) break;
    if (!done) ++refused_;
    done = {};
    pending_objects_.pop_front();
  }
  if (done && finish) done = objects_.Close();
  const std::string trouble = done ? std::string() : "changed objects: " + done.error().message;
  if (trouble != objects_trouble_) {
    objects_trouble_ = trouble;
    say_(done ? "changed objects are registered again" : trouble + "; they wait, trying again");
  }
  return done;
}

core::Expected<void> StoreFeeder::Commit() {
  auto registered = RegisterObjects(false);
  if (pending_.empty()) return registered;
  auto done = Attempt(false);
  Report(done);
  if (done) Acknowledge();
  return done;
}

core::Expected<void> StoreFeeder::Finish() {
  const auto registered = RegisterObjects(true);
  auto done = Attempt(true);
  Report(done);
  if (done) Acknowledge();
  return done ? registered : done;
}

void StoreFeeder::Acknowledge() {
  const core::MonoTime now = core::MonoNow();
  for (const Item& item : pending_) {
    const gis::PanoramaRecord* p = item.picture();
    if (p == nullptr) continue;
    const double latency_s = core::ToSeconds(now - item.received);
    if (latencies_s_.size() < kMostLatencies) {
      latencies_s_.push_back(latency_s);
    } else {
      latencies_s_[next_latency_++ % kMostLatencies] = latency_s;
    }
    if (csv_)
      std::fprintf(csv_.get(), "%lld,%lld,%s,%lld,%lld\n", static_cast<long long>(p->epoch),
                   static_cast<long long>(p->pose.time.ns()),
                   p->stage == gis::PictureStage::kFull ? "full" : "preview",
                   static_cast<long long>(now.ns()), static_cast<long long>(item.received.ns()));
  }
  if (csv_ && pending_pictures_ > 0) std::fflush(csv_.get());
  pending_.clear();
  handed_ = 0;
  pending_pictures_ = 0;
}

double StoreFeeder::LatencyQuantileS(double p) const {
  if (latencies_s_.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted = latencies_s_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(std::lround(p * static_cast<double>(sorted.size() - 1)))];
}

}  // namespace kawara::station
