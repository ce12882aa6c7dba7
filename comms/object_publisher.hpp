#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/object_message.hpp"
#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/object_textures.hpp"
#include "core/time.hpp"

namespace kawara::comms {

struct PublisherOptions {
  std::string robot;
  std::string mission;
  core::Geodetic origin;  ///< of the plane the objects are in
  /// What was said once is said again in turns, one message in this time, for those who missed it:
  /// the newest revision of every object, and its textures. Zero: never.
  core::Duration repeat{};
};

/// The 3rd update as messages: OBJECT, OBJECT.TEXTURE and ROAD, on a bus or into a log. One thread.
class ObjectPublisher {
 public:
  using Send = std::function<core::Expected<void>(std::string_view channel,
                                                  const std::vector<std::uint8_t>& message)>;
  ObjectPublisher(PublisherOptions options, Send send);

  /// Errors: those of ToMessage and of sending; what was sent before stays sent.
  core::Expected<void> Publish(const core::ChangedObject& object);
  core::Expected<void> Publish(const std::string& uid, std::uint64_t revision,
                               const core::ObjectTextures& textures);
  core::Expected<void> Publish(std::span<const core::RoadStation> stations);

  /// Says something again if it is time. Call it regularly. Errors: those of sending.
  core::Expected<void> Repeat(core::MonoTime now);

 private:
  struct Message {
    std::string channel;
    std::vector<std::uint8_t> bytes;
  };
  /// Things in the order in which they are said again, message by message.
  class Round {
   public:
    explicit Round(std::size_t most) : most_(most) {}
    void Keep(const std::string& key, std::vector<Message> messages);
    const Message* Next();  ///< null: nothing is kept

   private:
    std::size_t most_;
    std::map<std::string, std::vector<Message>> said_;  ///< the newest of each key only
    std::deque<std::string> order_;                     ///< keys of said_, longest kept in front
    std::string next_key_;
    std::size_t next_part_ = 0;
  };
  core::Expected<void> SendAndKeep(std::vector<Message> messages, const std::string& key,
                                   Round& round);

  PublisherOptions options_;
  Send send_;
  Round objects_, roads_;  ///< a long road does not crowd out the objects
  bool roads_turn_ = false;
  core::MonoTime last_;
};

}  // namespace kawara::comms
