// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/cold_starts.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <stdexcept>

namespace slam::cold_starts_test {
namespace {

namespace fs = std::filesystem;

std::string textOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(ColdStarts, AreWrittenWithAllDigitsAndNothingWhereNothingWasFound) {
  ColdStartReport report;
  report.starts.resize(2);
  ColdStart& found = report.starts[0];
  found.begin = 1.5;
  found.found = true;
  found.after = 2.25;
  found.T_map_base = {0.1, -7.0, 1.0 / 3.0};
  found.searches = {{1.0, 3.5, {}}, {2.25, 6.0, {}}};
  report.starts[1].begin = 4.0;
  report.starts[1].searches = {{9.0, 0.5, {}}};
  const fs::path file = fs::path(testing::TempDir()) / "cold_starts_test.csv";

  writeStarts(report, file);

  EXPECT_EQ(textOf(file),
            "begin_s,after_s,x_m,y_m,theta_rad,searches\n"
            "1.5,2.25,0.10000000000000001,-7,0.33333333333333331,1 3.5 2.25 6\n"
            "4,,,,,9 0.5\n");
  fs::remove(file);
}

TEST(ColdStarts, ReportWhichFileCannotBeWritten) {
  try {
    writeStarts({}, "/dev/null/starts.csv");
    FAIL() << "nothing thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("/dev/null/starts.csv"), std::string::npos);
  }
}

}  // namespace
}  // namespace slam::cold_starts_test
