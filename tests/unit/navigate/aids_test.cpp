#include "tools/navigate/aids.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/navigate/test_files.hpp"
#include "tools/navigate/decimal_time.hpp"
#include "tools/navigate/merge.hpp"

namespace kawara::navigate {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kGnss =
    "t,lat,lon,h,q,t_rx,heading\n"
    "1,2,3,4,1,1.3,\n2,2,3,4,1,2.1,10\n3,2,3,4,2,3.1,\n4,2,3,4,1,4.1,\n5,2,3,4,1,5.1,\n";

class AidsTest : public WithFiles {
 protected:
  AidFiles Files() const {
    AidFiles files;
    files.gnss = File(kGnss, "gnss.csv");
    return files;
  }
  WithheldFiles withheld_;
};

/// "fix 1.000", "heading 2.000", "wheels 1.500", ... by what it is and when it was measured.
std::string Name(const Aid& aid) {
  struct {
    std::string operator()(const core::GnssFix& fix) { return "fix " + FormatSeconds(fix.time); }
    std::string operator()(const estimation::OdometrySample& s) {
      return "wheels " + FormatSeconds(s.time);
    }
    std::string operator()(const estimation::AttitudeSample& s) {
      return (s.has_level ? "attitude " : "heading ") + FormatSeconds(s.time);
    }
  } name;
  return std::visit(name, aid.data);
}

std::vector<std::string> Names(const std::vector<Aid>& aids) {
  std::vector<std::string> names;
  for (const Aid& aid : aids) names.push_back(Name(aid));
  return names;
}

TEST_F(AidsTest, MergedByTimeOfValidity) {
  AidFiles files = Files();
  files.odometry = File("t,vx\n1.5,0\n2,0\n4.5,0\n", "odo.csv");
  files.attitude = File("t,roll,pitch\n0.5,0,0\n", "ahrs.csv");
  const auto aids = ReadAids(files, withheld_);
  ASSERT_TRUE(aids) << aids.error().message;
  EXPECT_THAT(
      Names(aids->given),
      ElementsAre("attitude 0.500", "fix 1.000", "wheels 1.500", "fix 2.000", "heading 2.000",
                  "wheels 2.000", "fix 3.000", "fix 4.000", "wheels 4.500", "fix 5.000"));
}

TEST_F(AidsTest, OrByArrival) {
  AidFiles files = Files();
  files.use_arrival_times = true;
  files.odometry = File("t,vx\n1.2,0\n2.05,0\n", "odo.csv");
  const auto aids = ReadAids(files, withheld_);
  ASSERT_TRUE(aids) << aids.error().message;
  EXPECT_THAT(Names(aids->given),
              ElementsAre("wheels 1.200", "fix 1.000", "wheels 2.050", "fix 2.000", "heading 2.000",
                          "fix 3.000", "fix 4.000", "fix 5.000"));
}

TEST_F(AidsTest, BlankedEpochsAreReferencesOnly) {
  AidFiles files = Files();
  withheld_.blank = File("t_start,t_end\n2,4\n", "blank.csv");
  const auto aids = ReadAids(files, withheld_);
  ASSERT_TRUE(aids) << aids.error().message;
  EXPECT_THAT(Names(aids->given), ElementsAre("fix 1.000", "fix 4.000", "fix 5.000"));
  ASSERT_EQ(aids->references.size(), 5U);
  EXPECT_EQ(aids->references[1].role, Reference::Role::kBlanked);
  EXPECT_EQ(aids->references[2].role, Reference::Role::kBlanked);
  EXPECT_EQ(aids->references[3].role, Reference::Role::kGiven);
}

TEST_F(AidsTest, HeldOutEpochsAreFoundToTheMillisecond) {
  AidFiles files = Files();
  withheld_.hold_out = File("t\n4.0004\n1\n99\n", "holdout.csv");
  const auto aids = ReadAids(files, withheld_);
  ASSERT_TRUE(aids) << aids.error().message;
  EXPECT_THAT(Names(aids->given),
              ElementsAre("fix 2.000", "heading 2.000", "fix 3.000", "fix 5.000"));
  EXPECT_EQ(aids->references[0].role, Reference::Role::kHeldOut);
  EXPECT_EQ(aids->references[3].role, Reference::Role::kHeldOut);
}

TEST_F(AidsTest, HoldOutThatFitsNothingIsAMistake) {
  AidFiles files = Files();
  withheld_.hold_out = File("t\n77\n88\n", "holdout.csv");
  const auto aids = ReadAids(files, withheld_);
  ASSERT_FALSE(aids);
  EXPECT_THAT(aids.error().message, HasSubstr("holdout.csv: none of its 2 epochs is among"));
}

TEST_F(AidsTest, GnssOutOfOrderIsPutInOrder) {
  AidFiles files;
  files.gnss = File("t,lat,lon,h,q\n3,2,3,4,1\n1,2,3,4,1\n2,2,3,4,1\n", "gnss.csv");
  const auto aids = ReadAids(files, withheld_);
  ASSERT_TRUE(aids) << aids.error().message;
  EXPECT_THAT(Names(aids->given), ElementsAre("fix 1.000", "fix 2.000", "fix 3.000"));
  EXPECT_EQ(aids->references[0].time, *ParseSeconds("1"));
}

std::vector<std::string> Order(const std::string& imu_path, const std::vector<Aid>& aids) {
  auto imu = ImuFile::Open(imu_path);
  EXPECT_TRUE(imu);
  std::vector<std::string> order;
  EXPECT_TRUE(Merge([&] { return imu->Next(); }, aids,
                    {[&](const estimation::ImuSample& sample) -> core::Expected<void> {
                       order.push_back("imu " + FormatSeconds(sample.time));
                       return {};
                     },
                     [&](const Aid& aid) { order.push_back(Name(aid)); }}));
  return order;
}

TEST_F(AidsTest, AnAidComesBeforeTheFirstSampleThatIsNotEarlier) {
  const auto aids = ReadAids(Files(), withheld_);
  ASSERT_TRUE(aids) << aids.error().message;
  const std::string imu = File(
      "t,wx,wy,wz,ax,ay,az\n0.5,0,0,0,0,0,-9.8\n1,0,0,0,0,0,-9.8\n2.5,0,0,0,0,0,-9.8\n"
      "2.4,0,0,0,0,0,-9.8\n3.5,0,0,0,0,0,-9.8\n",
      "imu.csv");
  EXPECT_THAT(Order(imu, aids->given),
              ElementsAre("imu 0.500", "fix 1.000", "imu 1.000", "fix 2.000", "heading 2.000",
                          "imu 2.500", "imu 2.400", "fix 3.000", "imu 3.500"));
}

TEST_F(AidsTest, AFailingSinkEndsTheMerge) {
  auto imu =
      ImuFile::Open(File("t,wx,wy,wz,ax,ay,az\n1,0,0,0,0,0,-9.8\n2,0,0,0,0,0,-9.8\n", "imu.csv"));
  ASSERT_TRUE(imu);
  int samples = 0;
  const auto ok = Merge([&] { return imu->Next(); }, {},
                        {[&](const estimation::ImuSample&) -> core::Expected<void> {
                           ++samples;
                           return core::Fail(core::ErrorCode::kFull, "disk full");
                         },
                         [](const Aid&) {}});
  EXPECT_FALSE(ok);
  EXPECT_EQ(samples, 1);
}

}  // namespace
}  // namespace kawara::navigate
