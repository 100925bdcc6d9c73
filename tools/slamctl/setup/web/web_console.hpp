// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "config/config.hpp"
#include "problems/problem.hpp"
#include "tools/slamctl/setup/console.hpp"
#include "tools/slamctl/setup/web/joystick.hpp"

namespace slam {

/// Asks and reports by data that pages fetch, each of them the same; what is printed goes to the terminal, too. The
/// set-up has one thread, which waits in answerTo(); requests come from others.
class WebConsole : public Console {
 public:
  static constexpr std::size_t kLongestAnswer = 400;  ///< [bytes]

  explicit WebConsole(std::ostream& terminal) : terminal_(terminal) {}

  std::ostream& out() override { return printed_; }
  bool hasPerson() const override { return true; }
  std::string answerTo(const Question& question) override;
  void enter(SetupStep step) override;
  using Console::show;
  void show(const Machine& machine) override;
  void show(const DriveProgress& progress) override;
  void show(const DriveCalibration& calibration) override;
  void showPictures(const std::string& scans, const std::string& map) override;
  void showNoCalibration(const std::string& reason) override;
  void show(const PlannedChanges& changes) override;
  void show(const Findings& findings) override;
  /// Waits until somebody at a page has seen it.
  void show(const SetupOutcome& outcome) override;
  bool isPage() const override { return true; }
  void giveJoystick(const Config& config) override;
  /// The set-up ends by this. Waits until somebody at a page has seen it.
  void fail(const std::string& reason);

  /// All that a page shows: docs/api.md has the fields.
  std::string state() const;
  /// PNG of a drive, scans or map; empty: none.
  std::string picture(const std::string& name) const;
  /// The answer to the question of this number. @return none, or why it is not taken
  Problem take(std::uint64_t number, const std::string& answer);
  /// Drives while a drive is recorded. @return none, or why not @throws CommandRefused where nothing can be sent
  Problem drive(const DriveRequest& request);

 private:
  void put(const char* key, nlohmann::json value);
  void endDrive();
  void finish();

  std::ostream& terminal_;
  std::ostringstream printed_;  // of the set-up's thread
  mutable std::mutex mutex_;    // of these
  nlohmann::json state_ = {{"step", "find"}, {"answered", nlohmann::json::array()}, {"question", nullptr}, {"log", ""}};
  std::map<std::string, std::string> pictures_;
  std::optional<std::string> answer_;
  std::uint64_t number_ = 0;  // of the question
  std::condition_variable answered_;
  std::mutex driving_;  // of the two below
  std::shared_ptr<Joystick> joystick_;
  bool drives_ = false;
};

}  // namespace slam
