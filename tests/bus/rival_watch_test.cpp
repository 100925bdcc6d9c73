// SPDX-License-Identifier: BSD-3-Clause
#include "bus/rival_watch.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace slam::rival_watch_test {
namespace {

using namespace std::chrono_literals;

class RivalWatchTest : public testing::Test {
 protected:
  /// A second of poses of our own at 50 Hz, which come back a little later, and of another's at so many hertz.
  void second(int others) {
    for (int i = 0; i < 50; ++i, now_ += 20ms) {
      const auto message = messageOf(0);
      watch_.sent(message);
      waiting_.push_back(message);
      if (waiting_.size() > 10) {
        watch_.received(waiting_.front(), now_);
        waiting_.erase(waiting_.begin());
      }
      if (others > 0 && i % (50 / others) == 0) watch_.received(messageOf(1), now_);
    }
  }
  std::vector<std::uint8_t> messageOf(std::uint8_t who) {
    ++count_;
    std::vector<std::uint8_t> message(64, who);
    for (std::size_t i = 0; i < 8; ++i) message[i] = static_cast<std::uint8_t>(count_ >> 8 * i);
    return message;
  }

  RivalWatch watch_;
  Timestamp now_{100s};
  std::uint64_t count_ = 0;
  std::vector<std::vector<std::uint8_t>> waiting_;
};

TEST_F(RivalWatchTest, RecognisesItsOwnMessagesWhenTheyComeBack) {
  for (int i = 0; i < 60; ++i) {
    second(0);
    ASSERT_FALSE(watch_.hasRival(now_));
  }
}

TEST_F(RivalWatchTest, NoticesAnotherPublisherWithinTwoSecondsAndThatItEnds) {
  for (const int others : {50, 10, 2}) {
    second(0);
    ASSERT_FALSE(watch_.hasRival(now_));
    second(others);
    EXPECT_TRUE(watch_.hasRival(now_)) << others;
    for (int i = 0; i < 4; ++i) second(0);
    EXPECT_FALSE(watch_.hasRival(now_)) << others;
  }
}

TEST_F(RivalWatchTest, TakesASingleMessageForNoRival) {
  second(1);
  EXPECT_FALSE(watch_.hasRival(now_));
  for (int i = 0; i < 5; ++i) second(0);
  second(1);
  EXPECT_FALSE(watch_.hasRival(now_));
}

TEST_F(RivalWatchTest, GoesOnWithOneThatPublishesSeldom) {
  second(10);
  for (int i = 0; i < 10; ++i) {
    second(1);
    EXPECT_TRUE(watch_.hasRival(now_));
  }
}

}  // namespace
}  // namespace slam::rival_watch_test
