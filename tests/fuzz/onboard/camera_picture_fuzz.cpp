// What a camera's socket sends, down to the packet that goes on the air: frames of any format and
// size are pictures or complaints, never a packet without a whole JPEG. The first byte picks camera
// model and exposure.
#include <cstdint>
#include <kawara/phase1_t.hpp>
#include <memory>
#include <span>

#include "comms/codec.hpp"
#include "core/check.hpp"
#include "drivers/camera_socket_client.hpp"
#include "onboard/phase1_assembler.hpp"

namespace {

using namespace kawara;
using onboard::Phase1Assembler;

vision::Phase1PictureConfig ConfigOf(bool doughnut, bool progressive) {
  vision::Phase1PictureConfig config;
  config.camera = doughnut ? "doughnut" : "equirectangular";
  config.doughnut.width_px = config.doughnut.height_px = 64;
  config.doughnut.center_u_px = config.doughnut.center_v_px = 31.5;
  config.doughnut.l_in_px = 8;
  config.doughnut.l_base_px = 16.25;
  config.doughnut.l_out_px = 30;
  config.panorama.width_px = 128;
  config.progressive = progressive;
  config.max_width_px = progressive ? 128 : 0;
  config.preview_width_px = 64;
  return config;
}

struct Maker {
  Maker(bool doughnut, bool progressive) {
    auto made = Phase1Assembler::Create(
        ConfigOf(doughnut, progressive), {"robot", "mission", "make", "model"},
        [this](std::span<const std::uint8_t> bytes) {
          const auto packet = comms::Decode<phase1_t>(bytes);
          CORE_CHECK(packet.has_value() && packet->jpeg.size() > 4);
          CORE_CHECK(packet->jpeg[0] == 0xff && packet->jpeg[1] == 0xd8);
          CORE_CHECK(packet->width > 0 && packet->height > 0);
          ++packets;
        },
        [this](const core::Error& error) {
          CORE_CHECK(!error.message.empty());
          ++complaints;
        });
    CORE_CHECK(made.has_value());
    assembler = std::make_unique<Phase1Assembler>(std::move(*made));
  }
  std::unique_ptr<Phase1Assembler> assembler;
  int packets = 0;
  int complaints = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  // Kept from one input to the next: a bad frame must leave them usable.
  static Maker makers[] = {{false, false}, {false, true}, {true, false}, {true, true}};
  Maker& maker = makers[data[0] % 4U];
  std::span<const std::uint8_t> rest(data + 1, size - 1);
  drivers::CameraFrameAssembler frames;
  std::int64_t epoch = 0;
  while (!rest.empty()) {
    auto frame = frames.Feed({}, rest);
    if (!frame || !*frame) break;
    maker.packets = maker.complaints = 0;
    maker.assembler->OnFrame(++epoch, *frame);
    onboard::ExposurePose pose;
    pose.epoch = epoch;
    pose.camera.valid = (data[0] & 4U) != 0;
    maker.assembler->OnPose(pose);
    while (maker.assembler->Work()) continue;
    CORE_CHECK(maker.packets == 2 || maker.complaints > 0);
  }
  return 0;
}
