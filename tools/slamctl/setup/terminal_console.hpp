// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "tools/slamctl/setup/console.hpp"

namespace slam {

/// Asks and reports by lines of text.
class TerminalConsole : public Console {
 public:
  /// @param in nullptr: nobody can be asked
  TerminalConsole(std::istream* in, std::ostream& out) : in_(in), out_(out) {}

  std::ostream& out() override { return out_; }
  bool hasPerson() const override { return in_ != nullptr; }
  std::string answerTo(const Question& question) override;

  using Console::show;
  void show(const DriveProgress& progress) override;
  void show(const DriveCalibration& calibration) override;
  void showNoCalibration(const std::string& reason) override;
  void show(const PlannedChanges& changes) override;
  void show(const Findings& findings) override;
  void show(const SetupOutcome& outcome) override;

 private:
  std::istream* in_;
  std::ostream& out_;
};

}  // namespace slam
