// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {

struct DriveCalibration;
struct DriveProgress;
struct Machine;

/// What a set-up asks, as data.
struct Question {
  enum Kind : std::uint8_t { kText, kYesNo, kChoice } kind = kText;
  std::string id;                         ///< key of the setting, or name of the decision
  std::string text;                       ///< for people
  std::string otherwise = {};             ///< of kText: what an empty answer takes
  std::vector<std::string> choices = {};  ///< of kChoice: the answer is the number of one, from 1, or empty: look again
  std::string error = {};                 ///< why the answer before was refused
};

/// What is to be written to a configuration.
struct PlannedChanges {
  std::string file;
  bool is_same = false;            ///< the file has it all
  std::vector<std::string> lines;  ///< of changedSettings()
};

/// How a set-up ended.
struct SetupOutcome {
  bool is_written = false;                ///< or was right already
  int faults = 0;                         ///< that the doctor found
  std::optional<bool> service_runs = {};  ///< again; std::nullopt: it was not stopped
  int live_port = 0;                      ///< of slam-web, where other computers may reach it; 0: they may not
  bool isGood() const { return is_written && faults == 0 && service_runs.value_or(true); }
};

enum class SetupStep : std::uint8_t { kFind, kAsk, kDrive, kCalibrate, kWrite, kCheck, kDone };

/// Where a set-up asks and reports: a terminal, or a page.
class Console {
 public:
  virtual ~Console() = default;

  /// For lines that people read.
  virtual std::ostream& out() = 0;
  /// Whether anybody can be asked.
  virtual bool hasPerson() const = 0;
  /// Waits for it. @return what was typed, without blanks around it; empty, too, where nobody can be asked
  virtual std::string answerTo(const Question& question) = 0;

  /// Whether it shows pictures, and a person can drive the robot from here.
  virtual bool isPage() const { return false; }
  /// Has that done while the next drive is recorded. @param config of that drive
  virtual void giveJoystick(const Config&) {}

  virtual void enter(SetupStep) {}
  virtual void show(const Machine&) {}
  virtual void show(const DriveProgress& progress) = 0;
  virtual void show(const DriveCalibration& calibration) = 0;
  /// Of a drive: scans over wheels, and the map. PNG; empty: none
  virtual void showPictures(const std::string& /*scans*/, const std::string& /*map*/) {}
  /// Why there is none.
  virtual void showNoCalibration(const std::string& reason) = 0;
  virtual void show(const PlannedChanges& changes) = 0;
  virtual void show(const Findings& findings) = 0;
  virtual void show(const SetupOutcome& outcome) = 0;
};

}  // namespace slam
