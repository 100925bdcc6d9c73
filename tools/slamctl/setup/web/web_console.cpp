// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/web/web_console.hpp"

#include <ostream>
#include <utility>

#include "bus/problem_message.hpp"
#include "problems/answers.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/slamctl/setup/drive_calibration.hpp"
#include "tools/slamctl/setup/drive_progress.hpp"
#include "tools/slamctl/setup/machine.hpp"

namespace slam {
namespace {

using nlohmann::json;

constexpr const char* kSteps[] = {"find", "ask", "drive", "calibrate", "write", "check", "done"};
constexpr const char* kKinds[] = {"text", "yes_no", "choice"};

json deviceJson(const FoundPort& port) {
  json device = {{"port", port.path},
                 {"adapter", port.description},
                 {"name", port.finding.name},
                 {"baud", port.finding.baud},
                 {"problem", nullptr}};
  if (port.finding.kind == PortFinding::kNothing)
    device["problem"] = problemJson(toMessage("port", port.finding.problem, false));
  return device;
}

json otherJson(const std::string& port, const std::string& name) {
  return {{"port", port}, {"adapter", ""}, {"name", name}, {"baud", 0}, {"problem", nullptr}};
}

}  // namespace

void WebConsole::put(const char* key, json value) {
  const std::string text = std::exchange(printed_, std::ostringstream()).str();
  terminal_ << text << std::flush;
  const std::lock_guard lock(mutex_);
  state_["log"].get_ref<std::string&>() += text;
  state_[key] = std::move(value);
}

std::string WebConsole::answerTo(const Question& question) {
  const std::uint64_t number = ++number_;  // nobody else writes it
  put("question", {{"number", number},
                   {"kind", kKinds[question.kind]},
                   {"id", question.id},
                   {"text", question.text},
                   {"default", question.otherwise},
                   {"choices", question.choices},
                   {"error", question.error}});
  std::unique_lock lock(mutex_);
  answered_.wait(lock, [this] { return answer_.has_value(); });
  return *std::exchange(answer_, std::nullopt);
}

Problem WebConsole::take(std::uint64_t number, const std::string& answer) {
  const std::lock_guard lock(mutex_);
  json& question = state_["question"];
  if (question.is_null() || question["number"] != number) return answer::kSetupAnswered;
  state_["answered"].push_back({{"id", question["id"]}, {"text", question["text"]}, {"answer", answer}});
  question = nullptr;
  answer_ = answer;
  answered_.notify_one();
  return {};
}

void WebConsole::enter(SetupStep step) {
  if (step == SetupStep::kDrive) put("progress", nullptr);
  put("step", kSteps[static_cast<std::size_t>(step)]);
}

void WebConsole::show(const Machine& machine) {
  json devices = json::array();
  for (const FoundPort& port : machine.ports) devices.push_back(deviceJson(port));
  for (const FoundBus& bus : machine.buses)
    devices.push_back(otherJson(bus.interface, !bus.nodes.empty() ? "ODrive" : !bus.vescs.empty() ? "VESC" : ""));
  for (const std::string& chip : machine.chips) devices.push_back(otherJson("IIO", chip));
  if (machine.camera) devices.push_back(otherJson("USB", "OpenNI2"));
  put("devices", std::move(devices));
}

void WebConsole::show(const DriveProgress& progress) {
  {
    const std::lock_guard lock(driving_);
    drives_ = progress.phase != DriveProgress::kOver;
  }
  if (progress.phase == DriveProgress::kOver) endDrive();
  put("progress", {{"over", progress.phase == DriveProgress::kOver},
                   {"seconds", rounded(progress.seconds)},
                   {"length", progress.length},
                   {"way", rounded(progress.way)},
                   {"straight", rounded(progress.straight)},
                   {"left", rounded(progress.left)},
                   {"right", rounded(progress.right)},
                   {"enough_straight", DriveProgress::kEnoughWay},
                   {"enough_turn", DriveProgress::kEnoughTurn}});
}

void WebConsole::show(const DriveCalibration& calibration) {
  put("no_calibration", nullptr);
  json values = json::array();
  for (const CalibratedValue& value : calibration.values)
    values.push_back({{"key", value.key},
                      {"unit", value.unit},
                      {"configured", value.configured},
                      {"estimated", value.estimated},
                      {"interval", value.interval},
                      {"wrong", value.is_wrong}});
  put("calibration", {{"values", std::move(values)},
                      {"open", calibration.open},
                      {"translation", {calibration.translation_before, calibration.translation_after}},
                      {"rotation", {calibration.rotation_before, calibration.rotation_after}},
                      {"gyro", {calibration.gyro_scale, calibration.gyro_interval}}});
}

void WebConsole::showPictures(const std::string& scans, const std::string& map) {
  const std::lock_guard lock(mutex_);
  pictures_ = {{"scans", scans}, {"map", map}};
  state_["pictures"] = {{"number", number_}, {"scans", !scans.empty()}, {"map", !map.empty()}};
}

std::string WebConsole::picture(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto at = pictures_.find(name);
  return at == pictures_.end() ? "" : at->second;
}

void WebConsole::showNoCalibration(const std::string& reason) {
  endDrive();
  out() << "Not calibrated: " << reason << "\n";
  put("no_calibration", reason);
}

void WebConsole::show(const PlannedChanges& changes) {
  put("changes", {{"file", changes.file}, {"same", changes.is_same}, {"lines", changes.lines}});
}

void WebConsole::show(const Findings& findings) { put("findings", findingsJson(findings)); }

void WebConsole::show(const SetupOutcome& outcome) {
  put("outcome", {{"good", outcome.isGood()},
                  {"written", outcome.is_written},
                  {"faults", outcome.faults},
                  {"live_port", outcome.live_port},
                  {"service", outcome.service_runs ? json(*outcome.service_runs) : json()}});
  finish();
}

void WebConsole::fail(const std::string& reason) {
  endDrive();
  put("failure", reason);
  enter(SetupStep::kDone);
  finish();
}

void WebConsole::finish() { answerTo({.kind = Question::kYesNo, .id = "finish", .text = "End the set-up"}); }

void WebConsole::giveJoystick(const Config& config) {
  const SpeedLimits& limits = config.base_device.limits;
  put("joystick", {{"max_speed", limits.max_speed}, {"max_turn_rate", limits.max_turn_rate}});
  const std::lock_guard lock(driving_);
  joystick_ = std::make_shared<Joystick>(config.lcm.url);
}

void WebConsole::endDrive() {
  std::shared_ptr<Joystick> ended;
  {
    const std::lock_guard lock(driving_);
    ended = std::exchange(joystick_, nullptr);
    drives_ = false;
  }
  if (ended) ended->end();  // a request may hold it still
  put("joystick", nullptr);
}

Problem WebConsole::drive(const DriveRequest& request) {
  std::shared_ptr<Joystick> joystick;
  {
    const std::lock_guard lock(driving_);
    if (drives_) joystick = joystick_;
  }
  return joystick ? joystick->take(request) : Problem(answer::kSetupStands);
}

std::string WebConsole::state() const {
  const std::lock_guard lock(mutex_);
  return textOf(state_);
}

}  // namespace slam
