// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/situation_means.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <utility>

namespace slam::situation_means_test {
namespace {

std::vector<AblationCase> casesOf(std::initializer_list<const char*> names) {
  std::vector<AblationCase> cases;
  for (const char* name : names) cases.emplace_back().name = name;
  return cases;
}

TEST(SituationMeans, TheNumberBehindTheFirstWordIsTheSeed) {
  EXPECT_EQ(situationOf("home 12, range-bias=0.03"), "home, range-bias=0.03");
  EXPECT_EQ(situationOf("hall 3"), "hall");
  EXPECT_EQ(situationOf("intel"), "intel");
  EXPECT_EQ(situationOf("office-floor 2 m"), "office-floor 2 m") << "a length";
  EXPECT_EQ(situationOf("corridor, 60 m"), "corridor, 60 m");
}

TEST(SituationMeans, DrivesOfOneSituationHaveOneMean) {
  const std::vector<AblationCase> cases = casesOf({"home 1, late", "hall 1", "home 2, late"});
  const auto means = situationMeans(cases, {{{0.1}, 0.0, 0.2}, {{}, 0.5, 0.0}, {{0.3}, 0.1, 0.0}},
                                    {{{0.2, 0.4}, 1.0, 0.0}, {{}, 0.0, 1.0}, {{0.5}, 0.0, 0.0}});
  ASSERT_EQ(means.size(), 2U);
  EXPECT_EQ(means[0].situation, "home, late");
  EXPECT_EQ(means[0].drives, 2);
  EXPECT_NEAR(means[0].with.error, 0.2, 1e-12);
  EXPECT_NEAR(means[0].with.lost, 0.05, 1e-12);
  EXPECT_NEAR(means[0].with.sure_and_wrong, 0.1, 1e-12);
  EXPECT_NEAR(means[0].without.error, 0.4, 1e-12) << "0.3, the mean of the first drive's two, and 0.5";
  EXPECT_NEAR(means[0].without.lost, 0.5, 1e-12);
  EXPECT_EQ(means[1].drives, 1);
  EXPECT_TRUE(std::isnan(means[1].with.error)) << "a situation without a truth";
  EXPECT_EQ(means[1].without.sure_and_wrong, 1.0);
}

}  // namespace
}  // namespace slam::situation_means_test
