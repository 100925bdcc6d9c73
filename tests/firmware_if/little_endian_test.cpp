// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/little_endian.hpp"

#include <gmock/gmock.h>
#include <limits>

namespace slam::little_endian::little_endian_test {
namespace {

using testing::ElementsAre;

TEST(LittleEndian, PutsTheLowByteFirst) {
  std::array<std::uint8_t, 6> bytes{};
  putWord(bytes, 0, 0x1234);
  putFloat(bytes, 2, 0.2F);  // 3E4CCCCD
  EXPECT_THAT(bytes, ElementsAre(0x34, 0x12, 0xCD, 0xCC, 0x4C, 0x3E));
  EXPECT_EQ(wordAt(bytes, 0), 0x1234);
  EXPECT_EQ(floatAt(bytes, 2), 0.2F);
}

TEST(LittleEndian, ReportsWhetherAllAreFinite) {
  std::array<std::uint8_t, 12> bytes{};
  std::array<float, 3> read{};
  putFloats(bytes, 0, std::array{1.0F, -2.5F, 1e-30F});
  EXPECT_TRUE(readFloats(bytes, 0, read));
  EXPECT_THAT(read, ElementsAre(1.0F, -2.5F, 1e-30F));
  for (const float bad : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    putFloat(bytes, 8, bad);
    EXPECT_FALSE(readFloats(bytes, 0, read)) << bad;
  }
}

}  // namespace
}  // namespace slam::little_endian::little_endian_test
