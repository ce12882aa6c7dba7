#include "core/base64.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace kawara::core {
namespace {

TEST(Base64, VectorsOfRfc4648) {
  for (const auto& [plain, coded] :
       std::initializer_list<std::pair<const char*, const char*>>{{"", ""},
                                                                  {"f", "Zg=="},
                                                                  {"fo", "Zm8="},
                                                                  {"foo", "Zm9v"},
                                                                  {"foob", "Zm9vYg=="},
                                                                  {"fooba", "Zm9vYmE="},
                                                                  {"foobar", "Zm9vYmFy"},
                                                                  {"\xFF\xFE\xFD", "//79"}}) {
    EXPECT_EQ(Base64(plain), coded);
  }
}

}  // namespace
}  // namespace kawara::core
