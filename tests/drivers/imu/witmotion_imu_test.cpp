// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <vector>

#include "drivers/imu/codec/witmotion_frames.hpp"
#include "drivers/imu/imu_protocols.hpp"

namespace slam::witmotion_imu_test {
namespace {

using namespace std::chrono_literals;
using witmotion::Frame;
using witmotion::Type;

/// A line at 9600 bit/s, on which each byte has its time.
class Line {
 public:
  Line() { protocol_->begin(kBaud); }
  void send(const Frame& frame) {
    for (const std::uint8_t byte : witmotion::encode(frame)) {
      now_ += transferTime(1, kBaud);
      protocol_->push(byte, now_, [this](const ImuSample& sample) { samples.push_back(sample); });
    }
  }
  void rest(Timestamp until) { now_ = std::max(now_, until); }
  std::vector<ImuSample> samples;

 private:
  static constexpr int kBaud = 9600;
  std::unique_ptr<ImuProtocol> protocol_ = makeWitmotionProtocol();
  Timestamp now_{1000s};
};

TEST(WitmotionImu, StampsASetByItsFirstByte) {
  Line line;
  for (int i = 0; i < 200; ++i) {
    line.rest(Timestamp{1000s} + i * 50ms);
    for (const Type type : {Type::kTime, Type::kAcceleration, Type::kTurnRate, Type::kAngle})
      line.send({type, {1, 2, 3}});
  }
  // The frame of the time goes before, 11.5 ms.
  const double stamp = toSeconds(line.samples.back().stamp - Timestamp{1000s});
  EXPECT_NEAR(stamp, 199 * 0.05 + 0.0115, 0.001);
}

TEST(WitmotionImu, HasSpecificForceAndRadians) {
  Line line;
  line.send({Type::kAcceleration, {0, 1024, 2048, 2500}});
  line.send({Type::kTurnRate, {-1000, 500, 164}});
  ASSERT_EQ(line.samples.size(), 1U);
  EXPECT_NEAR(line.samples[0].accel.z(), 9.80665, 1e-9) << "at rest, upwards";
  EXPECT_NEAR(line.samples[0].accel.y(), 0.5 * 9.80665, 1e-9);
  EXPECT_NEAR(line.samples[0].gyro.z(), 0.1747, 1e-4) << "10 deg/s";
  EXPECT_NEAR(line.samples[0].gyro.x(), -1.0653, 1e-4);
  EXPECT_TRUE(line.samples[0].rate_known);
}

TEST(WitmotionImu, NeverPairsTwoSets) {
  Line line;
  line.send({Type::kAcceleration, {0, 0, 2048}});
  line.send({Type::kTurnRate, {1, 1, 1}});
  line.send({Type::kTurnRate, {2, 2, 2}});  // its acceleration was lost
  EXPECT_EQ(line.samples.size(), 1U);
}

TEST(WitmotionImu, MarksTheEndOfItsRange) {
  Line line;
  line.send({Type::kAcceleration, {0, 0, 2048}});
  line.send({Type::kTurnRate, {0, 0, 32767}});
  ASSERT_EQ(line.samples.size(), 1U);
  EXPECT_FALSE(line.samples[0].rate_known);
}

}  // namespace
}  // namespace slam::witmotion_imu_test
