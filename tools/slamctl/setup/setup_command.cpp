// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/setup_command.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <unistd.h>

#include "config/file_edit.hpp"
#include "config/loader.hpp"
#include "config/printer.hpp"
#include "drivers/tcp_port.hpp"
#include "store/durable_file.hpp"
#include "tools/common/program.hpp"
#include "tools/slamctl/remote.hpp"
#include "tools/slamctl/setup/config_writer.hpp"
#include "tools/slamctl/setup/drive_calibration.hpp"
#include "tools/slamctl/setup/drive_pictures.hpp"
#include "tools/slamctl/setup/drive_recording.hpp"
#include "tools/slamctl/setup/paused_service.hpp"
#include "tools/slamctl/setup/proposal.hpp"
#include "tools/slamctl/setup/terminal_console.hpp"
#include "tools/slamctl/setup/web/setup_page.hpp"
#include "tools/slamctl/web_address.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

constexpr double kDriveSeconds = 60.0;
constexpr std::uint64_t kMostConfig = 1 << 20;  // [bytes]

/// A folder that goes with its object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "slamctl-setup-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

using Present = SetupCommand::Present;

Present presentConfig(const std::string& file, const std::vector<std::string>& overrides) {
  Present present;
  std::error_code error;
  if (fs::exists(file, error)) present.text = readFile(file, kMostConfig);
  present.start = parseConfig(present.text, file, overrides);
  present.set = setFrom(present.text, file, present.config);
  return present;
}

/// Ports that are looked at although the system does not list them: on the network, or of another name.
std::vector<std::string> namedPorts(const Interview& interview) {
  const Config& config = interview.config();
  std::vector<std::string> named;
  for (const auto& [key, port] : {std::pair<const char*, std::string>{"lidar.port", config.lidar_device.port},
                                  {"base.port", config.base_device.port},
                                  {"imu.port", config.imu_device.port}}) {
    std::error_code error;
    if (interview.isSet(key) && (isTcp(port) || fs::is_character_file(port, error))) named.push_back(port);
  }
  return named;
}

bool canCalibrate(const Config& config) {
  return config.lidar_device.isRead() && config.base_device.driver != BaseDriver::kNone &&
         config.base_device.driver != BaseDriver::kLcm && config.base_device.type == BaseType::kDifferential;
}

/// What is run while the drive is recorded: with a joystick, if there is one and the person agrees, it takes speeds,
/// and is slow. Otherwise it takes them only where the file has it so.
Config configOfDrive(Config config, Interview& interview) {
  constexpr SpeedLimits kSlow{.max_speed = 0.3, .max_turn_rate = 0.8};  // whose wheels may still be wrong
  Console& console = interview.console();
  // What nothing stops when slamd fails, as an ODrive without its watchdog, is pushed.
  const bool is_stopped = config.base_device.isSerial();
  if (!console.isPage() || !is_stopped ||
      !interview.agrees(
          "joystick",
          "Drive with the joystick of this page? The wheels turn then, slowly, while you hold it. Put the "
          "robot on the floor, with room around it, and stay within reach of its switch. No: you push it",
          false))
    return config;
  SpeedLimits& limits = config.base_device.limits;
  limits.max_speed = std::min(limits.max_speed, kSlow.max_speed);
  limits.max_turn_rate = std::min(limits.max_turn_rate, kSlow.max_turn_rate);
  config.base_device.speed_commands = true;
  console.giveJoystick(config);
  return config;
}

Config calibrated(const Config& config, double seconds, Interview& interview) {
  const TemporaryFolder folder;
  Config changed = config;
  Console& console = interview.console();
  const Config recorded = configOfDrive(config, interview);
  console.enter(SetupStep::kDrive);
  const fs::path log = recordDrive(recorded, seconds, folder.path(), console);
  console.enter(SetupStep::kCalibrate);
  console.show(calibrateDrive(changed, log));
  if (!console.isPage()) return changed;
  try {
    const ColourImage scans = scansOverWheels(config, changed, log);
    console.showPictures(scans.width > 0 ? encodePng(scans) : "", mapOfDrive(changed, log, folder.path()));
  } catch (const std::runtime_error& error) {  // what was calibrated is good without
    console.out() << "Not drawn: " << error.what() << "\n";
  }
  return changed;
}

/// @return whether the configuration is on the disk as wanted
bool write(const fs::path& target, const Present& present, const Config& wanted, Interview& interview, bool yes) {
  const std::string text = editedConfig(present.text, wanted);
  std::error_code error;
  const bool is_same = fs::exists(target, error) && readFile(target, kMostConfig) == text;
  interview.console().enter(SetupStep::kWrite);
  interview.console().show(PlannedChanges{target.string(), is_same, changedSettings(present.config, wanted)});
  if (is_same) return true;
  if (!yes && !interview.agrees("write", "Write them to " + target.string() + "?", false)) {
    interview.out() << "Nothing was written.\n";
    return false;
  }
  const fs::path old = writeConfig(target, text, wanted);
  interview.out() << target.string() << " is written" << (old.empty() ? "" : "; what was there is now " + old.string())
                  << ".\n";
  return true;
}

}  // namespace

SetupCommand::SetupCommand(CLI::App& app)
    : command_(app.add_subcommand(
          "setup", "find what is plugged in, ask for the rest, calibrate, write the configuration, run doctor")),
      seconds_(kDriveSeconds) {
  auto* web = command_->add_flag("--web", web_, "ask and show on a page, for a phone, whose address it prints");
  command_->add_flag("--qr", qr_, "print the page's address as a QR code, too, for a phone's camera")->needs(web);
  command_->add_option("--web-port", web_port_, "of the page; default: the one behind web.port; 0: any that is free")
      ->check(CLI::Range(0, 65535))
      ->needs(web);
  command_->add_flag("--yes", yes_, "ask nothing, take defaults where nothing is known, calibrate, and write")
      ->excludes(web);
  command_->add_option("--answers", answers_, "file of answers: section.key = value in each line")
      ->check(CLI::ExistingFile);
  command_->add_option("--write", write_, "write to this file; default: the configuration in use")->check(namesFile());
  command_->add_option("--port", ports_, "look at this port alone; may be repeated")->allow_extra_args(false);
  command_->add_flag("--calibrate", calibrate_, "calibrate by a drive without being asked");
  command_->add_flag("--stop-service", stop_service_,
                     "stop a slamd service that runs, which has the ports, without being asked; it is started again at "
                     "the end");
  command_->add_option("--drive", seconds_, "[s] of the drive that is recorded for the calibration; 0: none")
      ->check(inRange(0.0, 3600.0))
      ->capture_default_str();
}

bool SetupCommand::run(const std::string& config_file, const std::vector<std::string>& overrides) const {
  const Present present = presentConfig(config_file, overrides);
  const fs::path target = write_.empty() ? config_file : write_;
  if (access(fs::absolute(target).parent_path().c_str(), F_OK) == 0 &&
      access(fs::absolute(target).parent_path().c_str(), W_OK) != 0)
    throw std::runtime_error(target.string() +
                             ": you may not write there; run sudo slamctl setup, or give --write FILE");
  if (web_) {
    WebConfig web = present.config.web;
    web.port = web_port_ >= 0 ? web_port_ : web.port + 1;
    const TemporaryFolder folder;
    return setUpOnPage(web, folder.path(), qr_, [&](Console& console) { return carryOut(present, target, console); });
  }
  TerminalConsole console(yes_ ? nullptr : &std::cin, std::cout);
  return carryOut(present, target, console);
}

bool SetupCommand::carryOut(const Present& present, const fs::path& target, Console& console) const {
  Interview interview(present.start, present.set, console);
  if (!answers_.empty()) interview.readAnswers(answers_);

  std::optional<PausedService> paused;
  if (PausedService::runs() &&
      (stop_service_ ||
       interview.agrees("stop_service",
                        "The slamd service runs, and has the ports. Stop it until the set-up ends? The "
                        "robot stands then.",
                        false)))
    paused.emplace();
  const bool only = !ports_.empty();
  const std::vector<std::string> named = only ? ports_ : namedPorts(interview);
  const auto survey = [&] {
    console.enter(SetupStep::kFind);
    Machine machine = surveyMachine(named, only, console.out());
    console.show(machine);
    console.enter(SetupStep::kAsk);
    return machine;
  };
  proposeDevices(interview, survey(), survey);
  Config wanted = interview.config();
  parseConfig(editedConfig(present.text, wanted), target.string());  // it fits together, before anything is driven

  const auto wish = [&] {
    return calibrate_ || interview.agrees("calibrate",
                                          "Calibrate wheels and lidar by a drive of " +
                                              std::to_string(static_cast<int>(seconds_)) + " s now? You drive.",
                                          yes_);
  };
  for (bool is_wished = seconds_ > 0.0 && canCalibrate(wanted) && wish(); is_wished;) {
    try {
      wanted = calibrated(wanted, seconds_, interview);
      is_wished = false;
    } catch (const std::runtime_error& error) {  // the rest is of use without
      console.showNoCalibration(error.what());
      is_wished = console.isPage() && interview.agrees("again", "Not calibrated. Drive once more?", false);
    }
  }
  SetupOutcome outcome{.is_written = write(target, present, wanted, interview, yes_)};
  console.enter(SetupStep::kCheck);
  const Findings findings = diagnose(wanted, socketOf(wanted, target));
  console.show(findings);
  outcome.faults = static_cast<int>(std::count_if(
      findings.begin(), findings.end(), [](const Finding& finding) { return finding.level == Finding::kFault; }));
  if (!isThisComputerAlone(wanted.web.address)) outcome.live_port = wanted.web.port;
  if (paused) outcome.service_runs = paused->resume();
  console.enter(SetupStep::kDone);
  console.show(outcome);
  return outcome.isGood();
}

}  // namespace slam
