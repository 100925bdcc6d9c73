// SPDX-License-Identifier: BSD-3-Clause
#include "store/binary.hpp"

#include <cstdint>
#include <gtest/gtest.h>
#include <limits>

namespace slam::binary_test {
namespace {

TEST(Binary, ReadsBackWhatItWrote) {
  BinaryWriter out;
  out.put(std::uint8_t{200});
  out.put(std::int32_t{-5});
  out.put(-0.1);
  out.putBytes("abc");
  out.put(std::numeric_limits<std::uint64_t>::max());
  const std::string bytes = out.take();
  EXPECT_EQ(bytes.size(), 1U + 4 + 8 + 3 + 8);
  BinaryReader in(bytes);
  EXPECT_EQ(in.get<std::uint8_t>(), 200);
  EXPECT_EQ(in.get<std::int32_t>(), -5);
  EXPECT_EQ(in.get<double>(), -0.1);
  EXPECT_EQ(in.getBytes(3), "abc");
  EXPECT_FALSE(in.atEnd());
  EXPECT_EQ(in.get<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(in.atEnd());
}

TEST(Binary, IsLittleEndian) {
  BinaryWriter out;
  out.put(std::uint32_t{0x01020304});
  EXPECT_EQ(out.bytes(), "\x04\x03\x02\x01");
}

TEST(Binary, ReadsNothingBehindTheEnd) {
  BinaryReader in("1234567");
  EXPECT_THROW(in.get<double>(), std::runtime_error);
  EXPECT_THROW(in.getBytes(8), std::runtime_error);
  EXPECT_THROW(in.getBytes(std::numeric_limits<std::size_t>::max()), std::runtime_error);
  EXPECT_EQ(in.getBytes(7), "1234567") << "a refusal takes nothing";
  EXPECT_THROW(in.get<std::uint8_t>(), std::runtime_error);
}

TEST(Binary, AcceptsNoCountOfMoreThanThereIs) {
  for (const std::uint64_t count :
       {std::uint64_t{3}, std::uint64_t{1} << 32, std::uint64_t{1} << 61, std::numeric_limits<std::uint64_t>::max()}) {
    BinaryWriter out;
    out.put(count);
    out.putBytes(std::string(23, 'x'));
    BinaryReader in(out.bytes());
    EXPECT_THROW(in.getCount(8), std::runtime_error) << count;
  }
  BinaryWriter out;
  out.put(std::uint64_t{2});
  out.putBytes(std::string(23, 'x'));
  BinaryReader in(out.bytes());
  EXPECT_EQ(in.getCount(8), 2U);
}

}  // namespace
}  // namespace slam::binary_test
