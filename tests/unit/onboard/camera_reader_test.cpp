#include "onboard/camera_reader.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <mutex>

namespace kawara::onboard {
namespace {

/// Gives the frames it was given, then none.
class FilmedCamera : public drivers::Camera {
 public:
  explicit FilmedCamera(std::deque<drivers::Frame> film) : film_(std::move(film)) {}
  core::Expected<void> Trigger(std::uint32_t) override { return {}; }
  core::Expected<std::shared_ptr<const drivers::Frame>> Next(core::Duration) override {
    if (film_.empty()) return std::shared_ptr<const drivers::Frame>();
    auto frame = std::make_shared<const drivers::Frame>(std::move(film_.front()));
    film_.pop_front();
    return frame;
  }

 private:
  std::deque<drivers::Frame> film_;
};

drivers::Frame Exposed(std::uint32_t sequence, int ms) {
  drivers::Frame frame;
  frame.sequence = sequence;
  frame.exposure = core::Milliseconds(ms);
  frame.bytes = {1, 2, 3};
  return frame;
}

/// The inputs in their order: "4 ms" for a length of exposure, "#2" for a frame.
std::vector<std::string> Posted(std::deque<drivers::Frame> film) {
  const std::size_t frames = film.size();
  FilmedCamera camera(std::move(film));
  FrameTable table;
  InputInbox inbox;
  core::Counters counters;
  CameraReader reader(camera, table, inbox, counters);
  std::vector<std::string> posted;
  std::size_t seen = 0;
  for (int patience = 0; patience < 2000 && seen < frames; ++patience) {
    while (inbox.TryTake([&](InputKind kind, core::MonoTime, std::span<const std::uint8_t> bytes) {
      core::Duration length{};
      if (kind == InputKind::kShutter && Unpack(bytes, length)) {
        posted.push_back(std::to_string(length / core::Milliseconds(1)) + " ms");
      }
      if (kind == InputKind::kFrame) posted.push_back("#" + std::to_string(++seen));
    })) {
    }
    std::this_thread::sleep_for(core::Milliseconds(5));
  }
  return posted;
}

TEST(CameraReader, TellsALengthOfExposureAheadOfTheFirstFrameThatHasIt) {
  EXPECT_EQ(Posted({Exposed(1, 4), Exposed(2, 4), Exposed(3, 6), Exposed(4, 6)}),
            (std::vector<std::string>{"4 ms", "#1", "#2", "6 ms", "#3", "#4"}));
}

TEST(CameraReader, SaysNothingOfWhatTheCameraDoesNotTell) {
  EXPECT_EQ(Posted({Exposed(1, 0), Exposed(2, 0)}), (std::vector<std::string>{"#1", "#2"}));
}

}  // namespace
}  // namespace kawara::onboard
