#include "drivers/unix_socket.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/test_folder.hpp"

/// That it connects is shown by the clients of the camera and the pulses.
namespace kawara::drivers {
namespace {

TEST(UnixSocket, ErrorsNameTheSocketTheReasonAndTheRemedy) {
  const kawara::testing::TestFolder folder;
  const std::string nobody = (folder / "nobody.sock").string();
  struct Case {
    std::string path;
    core::ErrorCode code;
    std::string message;
  };
  const Case cases[] = {
      {nobody, core::ErrorCode::kUnavailable,
       "lamp socket " + nobody + ": No such file or directory (is the lamp's program running?)"},
      {"", core::ErrorCode::kInvalidArgument,
       "lamp socket '': the path must have 1 to 107 characters"},
      {std::string(108, 'x'), core::ErrorCode::kInvalidArgument,
       "lamp socket '" + std::string(108, 'x') + "': the path must have 1 to 107 characters"},
  };
  for (const Case& c : cases) {
    const auto fd = ConnectUnix(c.path, "lamp socket", "the lamp's program");
    ASSERT_FALSE(fd.has_value()) << c.path;
    EXPECT_EQ(fd.error().code, c.code);
    EXPECT_EQ(fd.error().message, c.message);
  }
}

}  // namespace
}  // namespace kawara::drivers
