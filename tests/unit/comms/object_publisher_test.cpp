#include "comms/object_publisher.hpp"

#include <gtest/gtest.h>

#include <array>
#include <kawara/changed_object_t.hpp>
#include <set>
#include <utility>

#include "comms/codec.hpp"

namespace kawara::comms {
namespace {

using Sent = std::vector<std::pair<std::string, std::vector<std::uint8_t>>>;

core::ChangedObject Object(const std::string& uid, std::uint64_t revision) {
  core::ChangedObject object;
  object.uid = uid;
  object.revision = revision;
  object.box.size_m = {4.4, 1.7, 1.5};
  return object;
}

core::ObjectTextures Textures() {
  core::ObjectTextures textures;
  textures.atlas_jpeg.assign(2000, 0x5A);
  textures.width_px = textures.height_px = 64;
  return textures;
}

class ObjectPublisherTest : public ::testing::Test {
 protected:
  ObjectPublisher Publisher(core::Duration repeat) {
    return ObjectPublisher(
        {"rover", "m", {0.6, 2.4, 50.0}, repeat},
        [this](std::string_view channel, const std::vector<std::uint8_t>& bytes) {
          sent_.emplace_back(channel, bytes);
          return core::Expected<void>();
        });
  }
  Sent sent_;
};

TEST_F(ObjectPublisherTest, SaysEverythingOnce) {
  ObjectPublisher publisher = Publisher({});
  ASSERT_TRUE(publisher.Publish(Object("a", 1)));
  ASSERT_TRUE(publisher.Publish("a", 1, Textures()));
  const std::array<core::RoadStation, 3> stations{};
  ASSERT_TRUE(publisher.Publish(stations));
  ASSERT_EQ(sent_.size(), 5U);
  EXPECT_EQ(sent_[0].first, "OBJECT");
  EXPECT_EQ(sent_[1].first, "OBJECT.TEXTURE");
  EXPECT_EQ(sent_[4].first, "ROAD");
  ASSERT_TRUE(publisher.Repeat(core::MonoTime::FromNs(1'000'000'000'000)));
  EXPECT_EQ(sent_.size(), 5U);
}

TEST_F(ObjectPublisherTest, RepeatsTheNewestOfEachInTurnsAndNoFaster) {
  ObjectPublisher publisher = Publisher(core::Seconds(1));
  for (const std::uint64_t revision : {1U, 2U}) {
    ASSERT_TRUE(publisher.Publish(Object("a", revision)));
    ASSERT_TRUE(publisher.Publish(Object("b", revision)));
  }
  ASSERT_TRUE(publisher.Publish("a", 1, Textures()));
  const Sent first = std::exchange(sent_, {});
  for (int tenth = 10; tenth < 110; ++tenth)
    ASSERT_TRUE(publisher.Repeat(core::MonoTime::FromNs(100'000'000LL * tenth)));
  ASSERT_EQ(sent_.size(), 10U);
  // A round is a, its three parts, and b.
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(sent_[i], sent_[i + 5]);
  std::set<std::vector<std::uint8_t>> parts;
  for (std::size_t i = 0; i < 5; ++i) {
    if (sent_[i].first == "OBJECT.TEXTURE") {
      parts.insert(sent_[i].second);
    } else {
      EXPECT_EQ(Decode<changed_object_t>(sent_[i].second)->revision, 2);
    }
  }
  EXPECT_EQ(parts.size(), 3U);
}

TEST_F(ObjectPublisherTest, WhatIsKeptForRepeatingIsBounded) {
  ObjectPublisher publisher = Publisher(core::Nanoseconds(1));
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(publisher.Publish(Object(std::to_string(i), 1)));
  sent_.clear();
  std::set<std::string> uids;
  for (int i = 1; i <= 400; ++i) ASSERT_TRUE(publisher.Repeat(core::MonoTime::FromNs(10 * i)));
  for (const auto& [channel, bytes] : sent_) uids.insert(Decode<changed_object_t>(bytes)->uid);
  EXPECT_EQ(uids.size(), 64U);
  EXPECT_TRUE(uids.contains("199"));
}

}  // namespace
}  // namespace kawara::comms
