// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/terminal_console.hpp"

#include <gtest/gtest.h>
#include <sstream>

namespace slam::terminal_console_test {
namespace {

TEST(TerminalConsole, PrintsAQuestionOfEachKindAndTakesALine) {
  std::istringstream in(" 0.2 \n2\ny\n");
  std::ostringstream out;
  TerminalConsole console(&in, out);
  EXPECT_EQ(console.answerTo({.id = "lidar.x", .text = "How far ahead?", .otherwise = "0.0"}), "0.2");
  EXPECT_EQ(
      console.answerTo({.kind = Question::kChoice, .id = "lidar.port", .text = "2 devices", .choices = {"a", "b"}}),
      "2");
  EXPECT_EQ(console.answerTo({.kind = Question::kYesNo, .id = "write", .text = "Write it?", .error = "no"}), "y");
  EXPECT_EQ(out.str(),
            "How far ahead? (lidar.x) [0.0] "
            "2 devices:\n  1: a\n  2: b\nWhich one? Its number; or unplug the other and press Enter "
            "no\nWrite it? [y/N] ");
  EXPECT_TRUE(console.hasPerson());
  EXPECT_EQ(console.answerTo({.id = "lidar.y", .text = "How far left?", .otherwise = "0.0"}), "");
  EXPECT_FALSE(console.hasPerson()) << "the input has ended";
}

TEST(TerminalConsole, PrintsChangesAndWhatComesNext) {
  std::ostringstream out;
  TerminalConsole console(nullptr, out);
  console.show(PlannedChanges{"/x/slamd.toml", true, {}});
  console.show(PlannedChanges{"/x/slamd.toml", false, {"lidar.x = 0.1, was 0.0"}});
  console.showNoCalibration("too short");
  console.show(SetupOutcome{.is_written = true});
  console.show(SetupOutcome{.is_written = true, .faults = 1});
  console.show(SetupOutcome{.is_written = true, .service_runs = false});
  EXPECT_EQ(out.str(),
            "\nNothing is to be changed in /x/slamd.toml.\n\nChanges:\n  lidar.x = 0.1, was 0.0\n"
            "Not calibrated: too short\nNext: sudo systemctl enable --now slamd, or restart it; then slamctl status\n"
            "The slamd service does not start: journalctl -u slamd -n 50\n");
}

}  // namespace
}  // namespace slam::terminal_console_test
