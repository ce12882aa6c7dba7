#include "comms/object_publisher.hpp"

#include <algorithm>
#include <utility>

#include "comms/codec.hpp"
#include "comms/road_message.hpp"
#include "comms/texture_message.hpp"

namespace kawara::comms {
namespace {

/// Things that are said again; the oldest are left to those who heard them.
constexpr std::size_t kMostObjects = 64, kMostRoads = 256;

}  // namespace

void ObjectPublisher::Round::Keep(const std::string& key, std::vector<Message> messages) {
  std::erase(order_, key);
  order_.push_back(key);
  said_[key] = std::move(messages);
  if (order_.size() <= most_) return;
  said_.erase(order_.front());
  order_.pop_front();
}

const ObjectPublisher::Message* ObjectPublisher::Round::Next() {
  if (said_.empty()) return nullptr;
  auto turn = said_.lower_bound(next_key_);
  if (turn == said_.end() || turn->first != next_key_) next_part_ = 0;
  if (turn == said_.end()) turn = said_.begin();
  next_key_ = turn->first;
  const std::size_t part = std::min(next_part_, turn->second.size() - 1);
  next_part_ = part + 1;
  if (next_part_ == turn->second.size()) {
    next_part_ = 0;
    const auto after = std::next(turn);
    next_key_ = after == said_.end() ? std::string() : after->first;
  }
  return &turn->second[part];
}

ObjectPublisher::ObjectPublisher(PublisherOptions options, Send send)
    : options_(std::move(options)),
      send_(std::move(send)),
      objects_(kMostObjects),
      roads_(kMostRoads) {}

core::Expected<void> ObjectPublisher::SendAndKeep(std::vector<Message> messages,
                                                  const std::string& key, Round& round) {
  for (const Message& message : messages)
    if (auto sent = send_(message.channel, message.bytes); !sent) return sent;
  if (options_.repeat > core::Duration{}) round.Keep(key, std::move(messages));
  return {};
}

core::Expected<void> ObjectPublisher::Publish(const core::ChangedObject& object) {
  const auto message =
      ToMessage(ObjectReport{options_.robot, options_.mission, options_.origin, object});
  if (!message) return tl::unexpected(message.error());
  auto bytes = Encode(*message);
  if (!bytes) return tl::unexpected(bytes.error());
  std::vector<Message> messages;
  messages.push_back({"OBJECT", std::move(*bytes)});
  return SendAndKeep(std::move(messages), object.uid, objects_);
}

core::Expected<void> ObjectPublisher::Publish(const std::string& uid, std::uint64_t revision,
                                              const core::ObjectTextures& textures) {
  const auto parts =
      ToMessages(TextureReport{options_.robot, options_.mission, uid, revision, textures});
  if (!parts) return tl::unexpected(parts.error());
  std::vector<Message> messages;
  for (const object_texture_t& part : *parts) {
    auto bytes = Encode(part);
    if (!bytes) return tl::unexpected(bytes.error());
    messages.push_back({"OBJECT.TEXTURE", std::move(*bytes)});
  }
  return SendAndKeep(std::move(messages), uid + " texture", objects_);
}

core::Expected<void> ObjectPublisher::Publish(std::span<const core::RoadStation> stations) {
  const auto reports = ToMessages(RoadReport{
      options_.robot, options_.mission, options_.origin, {stations.begin(), stations.end()}});
  if (!reports) return tl::unexpected(reports.error());
  for (const road_stations_t& report : *reports) {
    auto bytes = Encode(report);
    if (!bytes) return tl::unexpected(bytes.error());
    std::vector<Message> messages;
    messages.push_back({"ROAD", std::move(*bytes)});
    const std::string key = "road " + report.road + " " + std::to_string(report.along_m.front());
    if (auto sent = SendAndKeep(std::move(messages), key, roads_); !sent) return sent;
  }
  return {};
}

core::Expected<void> ObjectPublisher::Repeat(core::MonoTime now) {
  if (options_.repeat == core::Duration{} || now - last_ < options_.repeat) return {};
  const Message* message = (roads_turn_ ? roads_ : objects_).Next();
  roads_turn_ = !roads_turn_;
  if (message == nullptr) message = (roads_turn_ ? roads_ : objects_).Next();
  if (message == nullptr) return {};
  last_ = now;
  return send_(message->channel, message->bytes);
}

}  // namespace kawara::comms
