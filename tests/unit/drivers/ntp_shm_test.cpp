#include "drivers/ntp_shm.hpp"

#include <gtest/gtest.h>
#include <sys/ipc.h>
#include <sys/shm.h>
#include <unistd.h>

#include <cstring>

namespace kawara::drivers {
namespace {

/// A time service's side: the segment as chrony 4.3's refclock_shm.c and ntpd's driver 28 document
/// it, by offsets.
class TimeService {
 public:
  static constexpr std::size_t kBytes = 96;  // of a 64-bit machine
  explicit TimeService(int unit)
      : id_(shmget(0x4e545030 + unit, kBytes, IPC_CREAT | IPC_EXCL | 0600)),
        bytes_(static_cast<char*>(shmat(id_, nullptr, 0))) {}
  ~TimeService() {
    shmdt(bytes_);
    shmctl(id_, IPC_RMID, nullptr);
  }
  TimeService(const TimeService&) = delete;
  TimeService& operator=(const TimeService&) = delete;
  bool good() const { return id_ >= 0; }
  template <class Number>
  Number At(std::size_t offset) const {
    Number number{};
    std::memcpy(&number, bytes_ + offset, sizeof(number));
    return number;
  }

 private:
  int id_;
  char* bytes_;
};

/// Another one for each process that tests at the time.
int Unit() { return 1000 + getpid() % 100'000; }

ClockComparison Comparison() {
  return {core::UtcTime::FromNs(1'750'000'000'123'456'789), 1'750'000'001'987'654'321, 3e-6};
}

TEST(NtpShm, TellsATimeServiceWhatItReads) {
  const TimeService service(Unit());
  ASSERT_TRUE(service.good());
  NtpShm shm(Unit());
  for (int i = 1; i <= 2; ++i) {
    ASSERT_TRUE(shm.Tell(Comparison()));
    EXPECT_EQ(service.At<int>(0), 1) << "mode";
    EXPECT_EQ(service.At<int>(4), 2 * i) << "count";
    EXPECT_EQ(service.At<std::int64_t>(8), 1'750'000'000);
    EXPECT_EQ(service.At<int>(16), 123'456);
    EXPECT_EQ(service.At<std::int64_t>(24), 1'750'000'001);
    EXPECT_EQ(service.At<int>(32), 987'654);
    EXPECT_EQ(service.At<int>(36), 0) << "leap";
    EXPECT_EQ(service.At<int>(40), -18) << "precision: 3.8 us";
    EXPECT_EQ(service.At<int>(48), 1) << "valid";
    EXPECT_EQ(service.At<unsigned>(52), 123'456'789U);
    EXPECT_EQ(service.At<unsigned>(56), 987'654'321U);
  }
}

TEST(NtpShm, NobodyThereIsSaidAndAServiceThatComesOrIsStartedAnewIsFound) {
  NtpShm shm(Unit());
  const auto nobody = shm.Tell(Comparison());
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, core::ErrorCode::kNotFound);
  EXPECT_NE(nobody.error().message.find("chrony.conf"), std::string::npos);
  for (int i = 0; i < 2; ++i) {
    const TimeService service(Unit());
    ASSERT_TRUE(service.good());
    ASSERT_TRUE(shm.Tell(Comparison()));
    EXPECT_EQ(service.At<int>(4), 2);
  }
  EXPECT_FALSE(shm.Tell(Comparison()));
}

}  // namespace
}  // namespace kawara::drivers
