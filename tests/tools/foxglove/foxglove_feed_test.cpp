// SPDX-License-Identifier: BSD-3-Clause
#include "tools/foxglove/foxglove_feed.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bus/messages.hpp"
#include "tools/foxglove/foxglove_json.hpp"

namespace slam::foxglove_feed_test {
namespace {

using nlohmann::json;
constexpr std::int64_t kBegin = 1'700'000'000'000'000, kSecond = 1'000'000;  // [us]

struct Sent {
  FoxgloveTopic topic;
  json message;
};

class FoxgloveFeedTest : public testing::Test {
 protected:
  std::vector<Sent> of(FoxgloveTopic topic) const {
    std::vector<Sent> some;
    std::copy_if(sent_.begin(), sent_.end(), std::back_inserter(some),
                 [topic](const Sent& one) { return one.topic == topic; });
    return some;
  }
  std::vector<Sent> sent_;
  std::optional<FoxgloveTopic> only_;
  FoxgloveFeed feed_{[this](FoxgloveTopic topic, std::int64_t, const json& message) {
                       sent_.push_back({topic, message});
                     },
                     [this](FoxgloveTopic topic) { return !only_ || only_ == topic; }};
};

scan_t scanAt(std::int64_t utime) {
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.1F;
  scan->range_max = 10.0F;
  scan->size = 1;
  scan->storage[0] = {.range = 2.0F, .bearing = 0.0F};
  return toMessage(*scan, utime);
}

problems_t problemsAt(std::int64_t utime, std::vector<std::string> ids) {
  problems_t message{};
  message.utime = utime;
  for (const std::string& id : ids) {
    problem_t problem{};
    problem.device = "lidar";
    problem.id = id;
    problem.level = 2;
    problem.cause = "cause";
    problem.fix = "fix";
    message.problems.push_back(problem);
  }
  message.nproblems = static_cast<std::int32_t>(message.problems.size());
  return message;
}

TEST_F(FoxgloveFeedTest, SendsTheMountsOnceASecondWithTheScans) {
  Config config;
  config.front_end.lidar.T_base_lidar = {0.2, 0.0, 0.0};
  feed_.mount(config);
  for (int i = 0; i < 11; ++i) EXPECT_TRUE(feed_.take(scanAt(kBegin + i * kSecond / 10)));
  EXPECT_EQ(of(FoxgloveTopic::kScan).size(), 11U);
  const auto transforms = of(FoxgloveTopic::kTransform);
  ASSERT_EQ(transforms.size(), 4U);
  EXPECT_EQ(transforms[0].message["child_frame_id"], "lidar");
  EXPECT_EQ(transforms[0].message["translation"]["x"], 0.2);
  EXPECT_FALSE(feed_.take(scan_t{}));
}

TEST_F(FoxgloveFeedTest, SendsNothingThatNobodyWants) {
  only_ = FoxgloveTopic::kPose;
  feed_.take(scanAt(kBegin));
  feed_.take(toMessage(PoseEstimate{}, kBegin, 1));
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].topic, FoxgloveTopic::kPose);
}

TEST_F(FoxgloveFeedTest, LogsAProblemWhenItBeginsAndAgainWhileItStands) {
  for (int second = 0; second < 31; ++second)
    feed_.take(problemsAt(kBegin + second * kSecond,
                          second < 10 ? std::vector<std::string>{"a"} : std::vector<std::string>{"a", "b"}));
  std::vector<std::string> ids;
  for (const Sent& line : of(FoxgloveTopic::kLog)) ids.push_back(line.message["file"]);
  EXPECT_THAT(ids, testing::ElementsAre("a", "b", "a"));
  EXPECT_EQ(sent_[0].message["level"], 4);
  EXPECT_EQ(sent_[0].message["message"], "cause; fix");
  feed_.take(problemsAt(kBegin + 32 * kSecond, {}));
  feed_.take(problemsAt(kBegin + 33 * kSecond, {"a"}));
  EXPECT_EQ(of(FoxgloveTopic::kLog).size(), 4U) << "it has come again";
}

TEST_F(FoxgloveFeedTest, DescribesEachMessageByItsChannelsSchema) {
  feed_.take(scanAt(kBegin));
  feed_.take(toMessage(PoseEstimate{}, kBegin, 1));
  feed_.take(toMessage(WheelSample{fromMicroseconds(kBegin), {}}, kBegin));
  feed_.take(toMessage(ImuSample{fromMicroseconds(kBegin), {}, {}}, kBegin));
  feed_.take(odometry_t{});
  feed_.take(health_t{});
  feed_.take(problemsAt(kBegin, {"a"}));
  feed_.take(MapPicture::Picture{kBegin, {}, 0.05, 1, 1, "a"});
  ASSERT_EQ(sent_.size(), 12U);
  for (const Sent& one : sent_) {
    const FoxgloveChannel& channel = foxgloveChannels()[static_cast<std::size_t>(one.topic)];
    EXPECT_EQ(foxglove::schemaOf(channel.schema_name, one.message), channel.schema) << channel.topic;
  }
}

}  // namespace
}  // namespace slam::foxglove_feed_test
