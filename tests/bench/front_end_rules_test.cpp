// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/front_end_rules.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <memory>
#include <set>

namespace slam::front_end_rules_test {
namespace {

TEST(FrontEndRules, EachChangesTheConfigurationAndHasANameOfItsOwn) {
  const auto untouched = std::make_unique<FrontEndConfig>();
  std::set<std::string_view> names;
  for (const Rule& rule : frontEndRules()) {
    EXPECT_TRUE(names.insert(rule.name).second) << rule.name;
    FrontEndConfig config;
    std::memcpy(static_cast<void*>(&config), untouched.get(), sizeof config);  // padding, too
    rule.leave_out(config);
    EXPECT_NE(std::memcmp(&config, untouched.get(), sizeof config), 0) << rule.name;
  }
}

}  // namespace
}  // namespace slam::front_end_rules_test
