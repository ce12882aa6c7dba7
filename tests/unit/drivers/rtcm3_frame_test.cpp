#include "drivers/rtcm3_frame.hpp"

#include <gtest/gtest.h>

#include "corrections_data.hpp"

namespace kawara::drivers {
namespace {

using testing::Append;
using testing::Bytes;
using testing::MakeRtcm3Frame;
using testing::ReadRecording;

/// All frames of a stream fed in pieces of 1..longest bytes, one after the other.
struct Result {
  Bytes frames;
  Rtcm3Framer::Stats stats;
  std::size_t pending = 0;
};
Result Cut(const Bytes& stream, std::size_t longest = SIZE_MAX / 2) {
  Result result;
  Rtcm3Framer framer;
  testing::ForPieces(stream, longest, [&](std::span<const std::uint8_t> piece) {
    while (const auto frame = framer.Next(piece)) Append(result.frames, *frame);
    EXPECT_TRUE(piece.empty());
  });
  result.stats = framer.stats();
  result.pending = framer.pending_bytes();
  return result;
}

const Bytes kSmall = MakeRtcm3Frame(Bytes{0x3E, 0xD0, 0x00});

TEST(Rtcm3Probe, Answers) {
  const Bytes frame = kSmall;
  Bytes damaged = frame;
  damaged[4] ^= 1;
  struct Case {
    const char* what;
    Bytes head;
    Rtcm3Match match;
    std::size_t length;
  };
  const Case cases[] = {
      {"nothing", {}, Rtcm3Match::kNoMatch, 0},
      {"other byte", {0x24, 0xD3}, Rtcm3Match::kNoMatch, 0},
      {"preamble only", {0xD3}, Rtcm3Match::kNeedMore, 3},
      {"half a length", {0xD3, 0x03}, Rtcm3Match::kNeedMore, 3},
      {"longest", {0xD3, 0x03, 0xFF}, Rtcm3Match::kNeedMore, 1029},
      {"all but one byte", Bytes(frame.begin(), frame.end() - 1), Rtcm3Match::kNeedMore, 9},
      {"whole", frame, Rtcm3Match::kFrame, 9},
      {"damaged", damaged, Rtcm3Match::kBadCrc, 9},
      {"empty frame", MakeRtcm3Frame(Bytes{}), Rtcm3Match::kFrame, 6},
      {"reserved bits set", MakeRtcm3Frame(Bytes{1, 2, 3}, 0x3F), Rtcm3Match::kFrame, 9}};
  for (const Case& c : cases) {
    const auto result = Rtcm3Probe(c.head);
    EXPECT_EQ(result.match, c.match) << c.what;
    EXPECT_EQ(result.length, c.length) << c.what;
  }
}

TEST(Rtcm3Probe, IgnoresWhatFollowsTheFrame) {
  Bytes more = kSmall;
  Append(more, Bytes{0xD3, 0x00, 0x13});
  const auto result = Rtcm3Probe(more);
  EXPECT_EQ(result.match, Rtcm3Match::kFrame);
  EXPECT_EQ(result.length, kSmall.size());
}

TEST(Rtcm3Framer, CountsOfTheRecordings) {
  struct Case {
    const char* file;
    std::uint64_t frames;
  };
  for (const Case& c : {Case{"rtcm3.log", 2}, Case{"rtcm3-2.log", 199}, Case{"testglo.rtcm3", 429},
                        Case{"ntrip_encode_chunked.bin", 292}}) {
    const Bytes stream = ReadRecording(c.file);
    const Result r = Cut(stream);
    EXPECT_EQ(r.stats.frames, c.frames) << c.file;
    EXPECT_EQ(r.stats.frame_bytes, r.frames.size()) << c.file;
    EXPECT_EQ(r.stats.frame_bytes + r.stats.skipped_bytes + r.pending, stream.size()) << c.file;
  }
}

TEST(Rtcm3Framer, AnySplitGivesTheSameFrames) {
  Bytes stream = ReadRecording("rtcm3-2.log");
  Append(stream, ReadRecording("rtcm3.log"));
  const Result whole = Cut(stream);
  for (const std::size_t longest : {1U, 2U, 3U, 7U, 64U, 500U, 2000U}) {
    const Result pieces = Cut(stream, longest);
    EXPECT_EQ(pieces.frames, whole.frames) << longest;
    EXPECT_EQ(pieces.stats.bad_crc, whole.stats.bad_crc) << longest;
    EXPECT_EQ(pieces.stats.skipped_bytes, whole.stats.skipped_bytes) << longest;
    EXPECT_EQ(pieces.pending, whole.pending) << longest;
  }
}

TEST(Rtcm3Framer, EveryCutOfTwoFramesInTwo) {
  Bytes stream{0x0D, 0x0A};
  Append(stream, kSmall);
  Append(stream, Bytes{0xD3, 0x00});  // false preamble
  Append(stream, kSmall);
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    Rtcm3Framer framer;
    int frames = 0;
    for (auto piece : {std::span<const std::uint8_t>(stream).first(cut),
                       std::span<const std::uint8_t>(stream).subspan(cut)}) {
      while (framer.Next(piece)) ++frames;
    }
    // The false preamble claims a frame of 211 + 6 bytes: the second frame is inside it and stays
    // undecided.
    EXPECT_EQ(frames, 1) << cut;
    Bytes rest(300, 0);
    std::span<const std::uint8_t> piece(rest);
    while (framer.Next(piece)) ++frames;
    EXPECT_EQ(frames, 2) << cut;
  }
}

TEST(Rtcm3Framer, FalsePreambleCostsOnlyItself) {
  const Bytes recording = ReadRecording("testglo.rtcm3");
  Bytes stream;
  std::span<const std::uint8_t> rest(recording);
  Rtcm3Framer source;
  while (const auto frame = source.Next(rest)) {
    Append(stream, Bytes{0xD3, 0x01, 0x55});  // claims 341 bytes of what follows
    Append(stream, *frame);
  }
  Append(stream, Bytes(1100, 0));
  const Result r = Cut(stream, 100);
  EXPECT_EQ(r.stats.frames, 429U);
  EXPECT_GE(r.stats.bad_crc, 429U);
}

TEST(Rtcm3Framer, OneWrongByteCostsOneFrame) {
  const Bytes stream = ReadRecording("testglo.rtcm3");
  for (std::size_t at = 500; at < stream.size(); at += 5003) {
    Bytes damaged = stream;
    damaged[at] ^= 0x10;
    EXPECT_EQ(Cut(damaged).stats.frames, 428U) << at;
  }
}

TEST(Rtcm3Framer, MissingBytesCostOneFrame) {
  const Bytes stream = ReadRecording("testglo.rtcm3");
  for (std::size_t at = 500; at + 3000 < stream.size(); at += 7001) {
    Bytes damaged = stream;
    damaged.erase(damaged.begin() + static_cast<std::ptrdiff_t>(at));
    EXPECT_EQ(Cut(damaged, 64).stats.frames, 428U) << at;
  }
}

TEST(Rtcm3Framer, TruncatedStreamKeepsTheRestPending) {
  Bytes stream = ReadRecording("testglo.rtcm3");
  stream.resize(stream.size() - 1);
  const Result r = Cut(stream);
  EXPECT_EQ(r.stats.frames, 428U);
  EXPECT_GT(r.pending, 0U);
}

TEST(Rtcm3Framer, ResetForgetsTheFrameBegun) {
  Rtcm3Framer framer;
  std::span<const std::uint8_t> half = std::span<const std::uint8_t>(kSmall).first(5);
  EXPECT_FALSE(framer.Next(half));
  framer.Reset();
  EXPECT_EQ(framer.pending_bytes(), 0U);
  EXPECT_EQ(framer.stats().skipped_bytes, 5U);
  std::span<const std::uint8_t> whole = kSmall;
  EXPECT_TRUE(framer.Next(whole));
}

TEST(Rtcm3Framer, DoesNotAllocate) {
  const Bytes stream = ReadRecording("rtcm3-2.log");
  Rtcm3Framer framer;
  const auto before = testing::AllocationsOfThisThread();
  std::size_t frames = 0;
  for (std::size_t i = 0; i < stream.size(); i += 50) {
    auto piece = std::span<const std::uint8_t>(stream).subspan(
        i, std::min<std::size_t>(50, stream.size() - i));
    while (framer.Next(piece)) ++frames;
  }
  EXPECT_EQ(testing::AllocationsOfThisThread(), before);
  EXPECT_EQ(frames, 199U);
}

}  // namespace
}  // namespace kawara::drivers
