// SPDX-License-Identifier: BSD-3-Clause
#include "bus/drive_senders.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::drive_senders_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr DriveSenders::Sender kA = 0x7F0000011389ULL, kB = 0xC0A80102EA60ULL, kC = 0x7F000001138AULL;

class DriveSendersTest : public testing::Test {
 protected:
  bool drive(DriveSenders& senders, DriveSenders::Sender from) { return senders.take(from, false, now_); }
  bool stop(DriveSenders& senders, DriveSenders::Sender from) { return senders.take(from, true, now_); }
  DriveSenders first_{DriveOrder::kFirst}, last_{DriveOrder::kLast};
  Timestamp now_{1000s};
};

TEST_F(DriveSendersTest, DriveWhatOneProgramSends) {
  for (int i = 0; i < 100; ++i, now_ += 100ms) {
    EXPECT_TRUE(drive(first_, kA));
    EXPECT_TRUE(drive(last_, kA));
  }
  now_ += 10s;
  EXPECT_TRUE(drive(first_, kA));
  EXPECT_TRUE(stop(first_, kA));
  EXPECT_TRUE(drive(first_, kA));
  EXPECT_FALSE(first_.problem(now_));
}

TEST_F(DriveSendersTest, FollowOneOfTwoByTheOrderThatIsSet) {
  EXPECT_TRUE(drive(first_, kA));
  EXPECT_TRUE(drive(last_, kA));
  for (int i = 0; i < 50; ++i) {
    now_ += 50ms;
    EXPECT_FALSE(drive(first_, kB)) << "A goes on";
    EXPECT_TRUE(drive(last_, kB));
    now_ += 50ms;
    EXPECT_TRUE(drive(first_, kA));
    EXPECT_FALSE(drive(last_, kA)) << "B began later";
  }
  now_ += 460ms;
  EXPECT_TRUE(drive(last_, kA)) << "B has ended";
  now_ += 100ms;
  EXPECT_TRUE(drive(first_, kB)) << "A has ended";
}

TEST_F(DriveSendersTest, StopForAZeroOfAnyAndDriveNobodyOnWhoWasStopped) {
  for (DriveSenders* senders : {&first_, &last_}) {
    EXPECT_TRUE(drive(*senders, kA));
    drive(*senders, kC);
    now_ += 50ms;
    EXPECT_TRUE(stop(*senders, kB));
    for (int i = 0; i < 50; ++i, now_ += 100ms) {
      EXPECT_FALSE(drive(*senders, kA));
      EXPECT_FALSE(drive(*senders, kC)) << "nor who waited";
    }
    EXPECT_TRUE(drive(*senders, kB)) << "who stopped them may drive";
    now_ += 501ms;
    EXPECT_TRUE(drive(*senders, kA)) << "after a pause";
    EXPECT_TRUE(stop(*senders, kB));
    EXPECT_FALSE(drive(*senders, kA));
    EXPECT_TRUE(stop(*senders, kA));
    EXPECT_TRUE(drive(*senders, kA)) << "after a zero of its own";
    now_ += 10s;
  }
}

TEST_F(DriveSendersTest, AreNamedWhileThereAreSeveral) {
  drive(first_, kA);
  EXPECT_FALSE(first_.problem(now_));
  now_ += 100ms;
  drive(first_, kB);
  EXPECT_THAT(first_.problem(now_).words(),
              AllOf(HasSubstr("2 programs (127.0.0.1:5001 is driven, 192.168.1.2:60000 waits)"),
                    HasSubstr("began first"), HasSubstr("fix: end the programs"), HasSubstr("base.drive_order")));
  stop(first_, kB);
  EXPECT_THAT(first_.problem(now_).words(),
              HasSubstr("(127.0.0.1:5001 was stopped by another one's zero, 192.168.1.2:60000 sends "
                        "zeros)"));
  drive(last_, kA);
  drive(last_, kB);
  EXPECT_THAT(last_.problem(now_).words(), HasSubstr("began last"));
  now_ += 1s;
  drive(first_, kA);
  EXPECT_TRUE(first_.problem(now_)) << "still fresh in mind";
  now_ += 1500ms;
  drive(first_, kA);
  EXPECT_FALSE(first_.problem(now_));
}

TEST_F(DriveSendersTest, RememberTheNewestOfMoreThanTheyHaveRoomFor) {
  for (DriveSenders::Sender sender = 1; sender < 1000; ++sender, now_ += 600ms) EXPECT_TRUE(drive(first_, sender));
  EXPECT_TRUE(drive(first_, kA));
  now_ += 1ms;
  EXPECT_FALSE(drive(first_, kB));
}

TEST_F(DriveSendersTest, HaveAClockEach) {
  const auto refusalOf = [&](DriveSenders::Sender from, Duration behind) {
    return first_.clock(from, now_).map(SenderClocks::kDrive, now_ - behind, Duration(0), now_).refusal;
  };
  for (int i = 0; i < 50; ++i, now_ += 100ms) {
    EXPECT_EQ(refusalOf(kA, 1ms), Refusal::kNone);
    EXPECT_EQ(refusalOf(kB, 30s) == Refusal::kNone, i >= 10) << "a clock that is late is known after a second";
  }
  first_.beginClocks(Duration(0));
  EXPECT_NE(refusalOf(kB, 30s), Refusal::kNone);
}

}  // namespace
}  // namespace slam::drive_senders_test
