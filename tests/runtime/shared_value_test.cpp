// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/shared_value.hpp"

#include <gtest/gtest.h>
#include <string>
#include <thread>

namespace slam::shared_value_test {
namespace {

TEST(SharedValue, IsReadAsItWasWrittenLast) {
  SharedValue<std::string> text;
  EXPECT_EQ(text.get(), "");
  const std::string a(1000, 'a'), b(2000, 'b');
  text.set(a);
  std::thread writer([&] {
    for (int i = 0; i < 1000; ++i) text.set(i % 2 == 0 ? b : a);
  });
  for (int i = 0; i < 1000; ++i) {
    const std::string read = text.get();
    EXPECT_TRUE(read == a || read == b);
  }
  writer.join();
  EXPECT_EQ(text.get(), a);
}

}  // namespace
}  // namespace slam::shared_value_test
