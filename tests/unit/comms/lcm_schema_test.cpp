#include "comms/lcm_schema.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <kawara/counters_t.hpp>
#include <kawara/phase1_t.hpp>
#include <random>

#include "comms/codec.hpp"
#include "comms/message_types.hpp"

namespace kawara::comms {
namespace {

using Blob = std::vector<std::uint8_t>;

// Fingerprints computed from the .lcm text are those that lcm-gen put into the generated types.
TEST(LcmSchema, FingerprintsAreLcmGens) {
  std::size_t types = 0;
  ForEachMessageType([&]<class T>(std::type_identity<T>) {
    ++types;
    const LcmType* type = LcmSchema::Builtin().Find(T::getTypeName());
    ASSERT_NE(type, nullptr) << T::getTypeName();
    EXPECT_EQ(type->fingerprint(), T::getHash()) << T::getTypeName();
  });
  EXPECT_EQ(types, LcmSchema::Builtin().types().size());
}

counters_t SomeCounters() {
  counters_t counters;
  counters.mono_ns = 123;
  counters.program = "kawara-onboard";
  counters.n = 2;
  counters.name = {"gps.bytes", "link.tx.expired"};
  counters.value = {5, -7};
  return counters;
}

TEST(Codec, RoundTrip) {
  const auto decoded = Decode<counters_t>(*Encode(SomeCounters()));
  ASSERT_TRUE(decoded.has_value());
  EXPECT_EQ(decoded->program, "kawara-onboard");
  EXPECT_EQ(decoded->name, SomeCounters().name);
  EXPECT_EQ(decoded->value, SomeCounters().value);
}

// No cut, no extension and no count from outside gets past the check, whatever the generated code
// would do with it.
TEST(Codec, EveryCutIsRefused) {
  const Blob good = *Encode(SomeCounters());
  for (std::size_t n = 0; n < good.size(); ++n) {
    EXPECT_FALSE(Decode<counters_t>(std::span(good).first(n)).has_value()) << n;
  }
  Blob longer = good;
  longer.push_back(0);
  EXPECT_FALSE(Decode<counters_t>(longer).has_value());
}

TEST(Codec, HostileCounts) {
  const Blob good = *Encode(SomeCounters());
  const std::size_t program_at = 16;
  const std::size_t n_at = program_at + 4 + 15;
  for (const std::size_t at : {program_at, n_at, n_at + 4}) {
    for (const std::uint32_t value :
         {0x80000000U, 0xffffffffU, 0x7fffffffU, 0x20000001U, 0x40000000U, 0U, 3U, 1U}) {
      Blob bytes = good;
      for (unsigned i = 0; i < 4; ++i)
        bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
      EXPECT_FALSE(Decode<counters_t>(bytes).has_value()) << at << " " << value;
    }
  }
}

TEST(Codec, RandomDamageNeverCrashes) {
  std::mt19937 random(7);
  const Blob good = *Encode(SomeCounters());
  for (int i = 0; i < 20000; ++i) {
    Blob bytes = good;
    for (int k = 0; k < 3; ++k)
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::uint8_t>(random());
    const auto decoded = Decode<counters_t>(bytes);
    if (decoded) {
      EXPECT_EQ(Encode(*decoded).value_or(Blob{}).size(), bytes.size());
    }
  }
}

class Lister : public LcmVisitor {
 public:
  std::vector<std::string> lines;
  void Integer(std::string_view path, LcmKind, std::int64_t value) override {
    Add(path, std::to_string(value));
  }
  void Real(std::string_view path, double value) override { Add(path, std::to_string(value)); }
  void Text(std::string_view path, std::string_view value) override {
    Add(path, std::string(value));
  }
  void Bytes(std::string_view path, std::span<const std::uint8_t> value) override {
    Add(path, std::to_string(value.size()) + " bytes");
  }

 private:
  void Add(std::string_view path, const std::string& value) {
    lines.push_back(std::string(path) + "=" + value);
  }
};

TEST(LcmType, VisitsLeavesInOrder) {
  Lister lister;
  ASSERT_TRUE(LcmSchema::Builtin().Find("counters_t")->Visit(*Encode(SomeCounters()), lister));
  EXPECT_EQ(lister.lines, (std::vector<std::string>{"mono_ns=123", "program=kawara-onboard", "n=2",
                                                    "name[0]=gps.bytes", "name[1]=link.tx.expired",
                                                    "value[0]=5", "value[1]=-7"}));
}

TEST(LcmType, VisitsStructsInside) {
  phase1_t phase1{};
  phase1.robot = "r";
  phase1.pose.lat_deg = 35.5;
  phase1.pose.velocity_enu_mps[1] = 2.0;
  phase1.n = 3;
  phase1.jpeg = {1, 2, 3};
  Lister lister;
  ASSERT_TRUE(LcmSchema::Builtin().TypeOf(*Encode(phase1))->Visit(*Encode(phase1), lister));
  for (const char* line :
       {"pose.lat_deg=35.500000", "pose.velocity_enu_mps[1]=2.000000", "jpeg=3 bytes"}) {
    EXPECT_NE(std::ranges::find(lister.lines, line), lister.lines.end()) << line;
  }
}

TEST(LcmSchema, RefusesBadText) {
  const struct {
    const char* text;
    const char* problem;
  } cases[] = {
      {"struct a {}", "no members"},
      {"struct a { b_t x; }", "no struct b_t"},
      {"struct a { a x; }", "nested too deep or in itself"},
      {"struct a { int32_t n; b x[n]; } struct b { int32_t n; a x[n]; }",
       "nested too deep or in itself"},
      {"struct a { int32_t x[n]; }", "array size"},
      {"struct a { int32_t x[0]; }", "array size"},
      {"struct a { double n; int32_t x[n]; }", "array size"},
      {"struct a { int32_t x; } struct a { int32_t x; }", "second time"},
      {"struct a { int32_t x[2000000000][2000000000]; }", "over 2 GiB"},
      {"struct a { int32_t x", "expected ';'"},
      {"struct a { int32_t x; /* never ends", "expected a name"},
      {"union a { int32_t x; }", "expected package or struct"},
  };
  for (const auto& c : cases) {
    const auto schema = LcmSchema::Parse(c.text);
    ASSERT_FALSE(schema.has_value()) << c.text;
    EXPECT_NE(schema.error().message.find(c.problem), std::string::npos)
        << c.text << ": " << schema.error().message;
  }
}

TEST(LcmSchema, ErrorsHaveTheirLine) {
  const auto schema =
      LcmSchema::Parse("package p;\n// a\nstruct a {\n  int32_t x;\n  int32_t y[z];\n}\n");
  ASSERT_FALSE(schema.has_value());
  EXPECT_NE(schema.error().message.find("line 5"), std::string::npos) << schema.error().message;
}

}  // namespace
}  // namespace kawara::comms
