// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/ablation.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <stdexcept>
#include <utility>

#include "tools/sim/log_mode.hpp"

namespace slam::ablation_test {
namespace {

namespace fs = std::filesystem;

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

TEST(Ablation, ALiftNeedsMapsAndTheTimeOfItsEnd) {
  const fs::path folder = fs::path(testing::TempDir()), config = folder / "ablation_test.toml",
                 log = folder / "ablation_test.lcm", file = folder / "ablation_test_lifts";
  std::ofstream(config).close();
  sim::SimOptions options{.scene = "home", .seed = 1, .seconds = 1.0};
  options.depth = false;
  sim::writeLog(options, log);
  const auto listOf = [&](const char* truth) {
    std::ofstream(file) << "homes 1 | lift | " << config.string() << " | " << log.string() << " | " << truth
                        << " | - | \n";
    return file;
  };
  const AblationCase lift = std::move(readCases(listOf("maps floor-1 floor-2 30.5")).front());
  EXPECT_EQ(lift.measure, AblationCase::Measure::kLift);
  EXPECT_EQ(lift.maps, "maps");
  EXPECT_EQ(lift.lift.begin_in, "floor-1");
  EXPECT_EQ(lift.lift.arrive_in, "floor-2");
  EXPECT_EQ(lift.lift.departs, 30.5);
  EXPECT_THROW(readCases(listOf("maps floor-1 floor-2")), std::runtime_error);
  for (const fs::path& made : {config, log, file}) fs::remove(made);
}

}  // namespace
}  // namespace slam::ablation_test
