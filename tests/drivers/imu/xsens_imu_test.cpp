// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <vector>

#include "drivers/imu/codec/xsens_messages.hpp"
#include "drivers/imu/imu_protocols.hpp"

namespace slam::xsens_imu_test {
namespace {

using namespace std::chrono_literals;

class Line {
 public:
  Line() { protocol_->begin(0); }
  void send(const xsens::Motion& motion, Timestamp now) {
    std::vector<std::uint8_t> bytes;
    xsens::encode(motion, bytes);
    push(bytes, now);
  }
  void push(const std::vector<std::uint8_t>& bytes, Timestamp now) {
    for (const std::uint8_t byte : bytes)
      protocol_->push(byte, now, [this](const ImuSample& sample) { samples.push_back(sample); });
  }
  ImuProtocol& protocol() { return *protocol_; }
  std::vector<ImuSample> samples;

 private:
  std::unique_ptr<ImuProtocol> protocol_ = makeXsensProtocol();
};

TEST(XsensImu, StampsByTheUnitsOwnTime) {
  Line line;
  // The third message is 7 ms late, and the unit's time wraps there.
  const std::uint32_t begin = 0xFFFFFFFFU - 150;
  for (int i = 0; i < 5; ++i)
    line.send({.ticks = begin + static_cast<std::uint32_t>(100 * i), .turn_rate = std::array{0.0, 0.0, 0.1 * i}},
              Timestamp{10s} + i * 10ms + (i == 2 ? 7ms : 0ms));
  ASSERT_EQ(line.samples.size(), 5U);
  for (int i = 0; i < 5; ++i)
    EXPECT_NEAR(toSeconds(line.samples[static_cast<std::size_t>(i)].stamp - Timestamp{10s}), 0.01 * i, 1e-5) << i;
}

TEST(XsensImu, KeepsTheUnitsAxesAndSigns) {
  Line line;
  line.send({.turn_rate = std::array{0.1, -0.2, 0.5}, .acceleration = std::array{0.0, 1.0, 9.81}}, Timestamp{10s});
  ASSERT_EQ(line.samples.size(), 1U);
  EXPECT_LT((line.samples[0].gyro - Eigen::Vector3d(0.1, -0.2, 0.5)).norm(), 1e-6);
  EXPECT_LT((line.samples[0].accel - Eigen::Vector3d(0.0, 1.0, 9.81)).norm(), 1e-5);
}

TEST(XsensImu, CountsMessagesWhoseBlocksDoNotFit) {
  Line line;
  std::vector<std::uint8_t> bytes;
  xsens::encode(xsens::Message{xsens::kData2, std::vector<std::uint8_t>{0x80, 0x20, 0x0C, 0x00}}, bytes);
  line.push(bytes, Timestamp{10s});
  EXPECT_EQ(line.protocol().damage(), 1U);
  EXPECT_EQ(line.protocol().frames(), 1U) << "the unit is there";
  EXPECT_TRUE(line.samples.empty());
}

TEST(XsensImu, IsAskedForNothingButToMeasure) {
  Line line;
  const Outgoing question = line.protocol().wakeUp();
  EXPECT_EQ(std::vector<std::uint8_t>(question.bytes().begin(), question.bytes().end()),
            (std::vector<std::uint8_t>{0xFA, 0xFF, 0x10, 0x00, 0xF1}));
}

}  // namespace
}  // namespace slam::xsens_imu_test
