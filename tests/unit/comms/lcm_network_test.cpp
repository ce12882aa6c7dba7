#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "comms/lcm_bus.hpp"

/// The live bus on a network of its own: a namespace whose loopback starts without multicast, as on
/// a bare robot.
namespace kawara::comms {
namespace {

constexpr int kCannot = 77;

template <class F>
int InNetworkNamespace(F f) {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::unshare(CLONE_NEWNET) != 0) ::_exit(kCannot);
    f();
    ::_exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LcmNetwork, NoRouteIsSaidWithItsCure) {
  const int status = InNetworkNamespace([] {
    const core::MonoTime begin = core::MonoNow();
    const auto bus = LcmBus::Open();
    ASSERT_FALSE(bus.has_value());
    EXPECT_EQ(bus.error().code, core::ErrorCode::kUnavailable);
    EXPECT_NE(bus.error().message.find("ip link set lo up multicast on"), std::string::npos)
        << bus.error().message;
    EXPECT_NE(bus.error().message.find("ip route replace 224.0.0.0/4 dev lo"), std::string::npos);
    // Found out by ourselves: LCM's self-test would have taken its 10 s.
    EXPECT_LT(core::MonoNow() - begin, core::Seconds(9));
  });
  if (status == kCannot) GTEST_SKIP() << "needs root for a network namespace";
  EXPECT_EQ(status, 0);
}

TEST(LcmNetwork, CuredByTheTwoCommandsAndCarriesPictures) {
  const int status = InNetworkNamespace([] {
    const char* cure = "ip link set lo up multicast on && ip route replace 224.0.0.0/4 dev lo";
    if (std::system(cure) != 0) ::_exit(kCannot);
    auto sender = LcmBus::Open();
    ASSERT_TRUE(sender.has_value()) << sender.error().message;
    auto receiver = LcmBus::Open();
    ASSERT_TRUE(receiver.has_value()) << receiver.error().message;
    EXPECT_NE((*receiver)->url().find("ttl=0"), std::string::npos);
    std::vector<std::size_t> sizes;
    ASSERT_TRUE((*receiver)->Subscribe(
        "PHASE1", [&](auto, auto data, const auto&) { sizes.push_back(data.size()); }));
    // A megabyte goes as 16 datagrams, which the kernel's default buffer does not hold.
    const std::vector<std::uint8_t> picture(1 << 20, 7);
    for (std::size_t i = 0; i < 5; ++i) {
      ASSERT_TRUE((*sender)->Publish("PHASE1", picture));
      for (int k = 0; k < 50 && sizes.size() <= i; ++k)
        ASSERT_TRUE((*receiver)->HandleFor(core::Milliseconds(100)));
    }
    if (!(*receiver)->warnings().empty())
      ::_exit(kCannot);  // this machine's rmem_max is too small, and it is said
    EXPECT_EQ(sizes, std::vector<std::size_t>(5, picture.size()));
  });
  if (status == kCannot) GTEST_SKIP() << "needs root, iproute2 and net.core.rmem_max >= 2 MiB";
  EXPECT_EQ(status, 0);
}

// More than the kernel grants cannot be had silently.
TEST(LcmNetwork, SmallKernelBufferIsWarnedAbout) {
  const auto bus = LcmBus::Open({.receive_buffer_bytes = 1 << 30});
  if (!bus) GTEST_SKIP() << bus.error().message;
  ASSERT_EQ((*bus)->warnings().size(), 1U);
  EXPECT_NE((*bus)->warnings()[0].find("sysctl -w net.core.rmem_max=1073741824"),
            std::string::npos);
}

}  // namespace
}  // namespace kawara::comms
