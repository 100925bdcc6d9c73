// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/storage_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/problems.hpp"

namespace slam::storage_watch_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class Disk : public testing::Test {
 protected:
  Disk() {
    watch.add("map", [this](Timestamp) { return report; });
  }
  std::vector<Trouble> troubles(Duration waiting) {
    report.waiting = waiting;
    return watch.troubles({});
  }

  StorageReport report;
  StorageWatch watch;
};

TEST_F(Disk, IsOneTroubleWhileItHangs) {
  EXPECT_TRUE(troubles(3s).empty());
  const auto hanging = troubles(7s);
  ASSERT_EQ(hanging.size(), 1U);
  EXPECT_THAT(hanging[0].text(),
              testing::AllOf(HasSubstr("map: the disk does not answer"), testing::EndsWith("(7 s so far)")));
  EXPECT_EQ(hanging[0].recovery, "map: the disk answers again");
}

TEST_F(Disk, IsNamedWithWhatIsNotStoredAndWhatIsLost) {
  report.problem = {test::problemOf("no room")};
  report.lost = {problem::kMessagesLost, {7.0}};
  const auto all = troubles(7s);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].text(), "map: no room");
  EXPECT_TRUE(all[0].error);
  EXPECT_EQ(all[1].text(), "map: 7 messages are missing in it: the disk was away or too slow");
  EXPECT_TRUE(all[1].recovery.empty()) << "they do not come back";
  for (const Trouble& one : all) {
    for (const Trouble& other : all) EXPECT_EQ(one.cause() == other.cause(), &one == &other);
  }
  report.problem = {test::problemOf("no space"), "not written since 14:03: ", "slamd tries again"};
  EXPECT_EQ(troubles(0s).at(0).text(), "map not written since 14:03: no space; slamd tries again");
}

}  // namespace
}  // namespace slam::storage_watch_test
