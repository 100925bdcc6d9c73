// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/text/log_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::log_page_test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(LogPage, LinksWhatCanBeAskedForAndNothingElse) {
  const std::string page = logPage({"run"}, {{"0001.lcm", false, 1'500'000}, {"a'b.lcm", false, 1}, {"more", true, 0}});
  EXPECT_THAT(page, HasSubstr("href=\"/logs/run/0001.lcm\""));
  EXPECT_THAT(page, HasSubstr("1.5 MB"));
  EXPECT_THAT(page, HasSubstr("href=\"/logs/run/more/\""));
  EXPECT_THAT(page, Not(HasSubstr("a'b")));
  EXPECT_THAT(page, HasSubstr("href=\"/logs/\""));
}

TEST(LogPage, OfAnEmptyFolderHasWordsInPlaceOfLinks) {
  EXPECT_THAT(logPage({}, {}), HasSubstr("Nothing is logged yet"));
  EXPECT_THAT(logPage({}, {{"run", true, 0}}), Not(HasSubstr("Nothing is logged yet")));
}

}  // namespace
}  // namespace slam::log_page_test
