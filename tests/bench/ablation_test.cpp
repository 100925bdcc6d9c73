// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/ablation.hpp"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <set>
#include <stdexcept>

namespace slam::ablation_test {
namespace {

namespace fs = std::filesystem;

TEST(Ablation, EveryRuleChangesTheConfigurationAndHasANameOfItsOwn) {
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

TEST(Ablation, AListThatCannotBeReadIsRefusedWithItsLine) {
  const fs::path file = fs::path(testing::TempDir()) / "ablation_test_cases";
  std::ofstream(file) << "# a comment\n\nhome | truth | no.toml | home.lcm\n";
  try {
    readCases(file);
    FAIL() << "nothing thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("ablation_test_cases:3: "), std::string::npos) << error.what();
  }
  fs::remove(file);
}

}  // namespace
}  // namespace slam::ablation_test
