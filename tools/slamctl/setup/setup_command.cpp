// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/setup_command.hpp"

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
#include "tools/slamctl/doctor.hpp"
#include "tools/slamctl/remote.hpp"
#include "tools/slamctl/setup/config_writer.hpp"
#include "tools/slamctl/setup/drive_calibration.hpp"
#include "tools/slamctl/setup/drive_recording.hpp"
#include "tools/slamctl/setup/paused_service.hpp"
#include "tools/slamctl/setup/proposal.hpp"

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

/// The configuration in use: its text, its values, and what it sets.
struct Present {
  std::string text;
  Config config;  // as the file has it
  Config start;   // with the command line's --set over it
  std::vector<std::string> set;
};

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

Config calibrated(const Config& config, double seconds) {
  const TemporaryFolder folder;
  Config changed = config;
  const DriveCalibration drive = calibrateDrive(changed, recordDrive(config, seconds, folder.path(), std::cout));
  print(drive, std::cout);
  return changed;
}

/// @return whether the configuration is on the disk as wanted
bool write(const fs::path& target, const Present& present, const Config& wanted, Interview& interview, bool yes) {
  const std::string text = editedConfig(present.text, wanted);
  const std::vector<std::string> lines = changedSettings(present.config, wanted);
  std::error_code error;
  if (fs::exists(target, error) && readFile(target, kMostConfig) == text) {
    std::cout << "\nNothing is to be changed in " << target.string() << ".\n";
    return true;
  }
  std::cout << (lines.empty() ? "\nNo value changes.\n" : "\nChanges:\n");
  for (const std::string& line : lines) std::cout << "  " << line << "\n";
  if (!yes && !interview.agrees("Write them to " + target.string() + "?", false)) {
    std::cout << "Nothing was written.\n";
    return false;
  }
  const fs::path old = writeConfig(target, text, wanted);
  std::cout << target.string() << " is written" << (old.empty() ? "" : "; what was there is now " + old.string())
            << ".\n";
  return true;
}

}  // namespace

SetupCommand::SetupCommand(CLI::App& app)
    : command_(app.add_subcommand(
          "setup", "find what is plugged in, ask for the rest, calibrate, write the configuration, run doctor")),
      seconds_(kDriveSeconds) {
  command_->add_flag("--yes", yes_, "ask nothing, take defaults where nothing is known, calibrate, and write");
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
  Interview interview(present.start, present.set, yes_ ? nullptr : &std::cin, std::cout);
  if (!answers_.empty()) interview.readAnswers(answers_);

  std::optional<PausedService> paused;
  if (PausedService::runs() &&
      (stop_service_ ||
       interview.agrees("The slamd service runs, and has the ports. Stop it until the set-up ends? The "
                        "robot stands then.",
                        false)))
    paused.emplace();
  const bool only = !ports_.empty();
  const std::vector<std::string> named = only ? ports_ : namedPorts(interview);
  const auto survey = [&] { return surveyMachine(named, only, std::cout); };
  proposeDevices(interview, survey(), survey);
  Config wanted = interview.config();
  parseConfig(editedConfig(present.text, wanted), target.string());  // it fits together, before anything is driven

  const auto wish = [&] {
    return calibrate_ || interview.agrees("Calibrate wheels and lidar by a drive of " +
                                              std::to_string(static_cast<int>(seconds_)) + " s now? You drive.",
                                          yes_);
  };
  if (seconds_ > 0.0 && canCalibrate(wanted) && wish()) {
    try {
      wanted = calibrated(wanted, seconds_);
    } catch (const std::runtime_error& error) {  // the rest is of use without
      std::cout << "Not calibrated: " << error.what() << "\n";
    }
  }
  const bool written = write(target, present, wanted, interview, yes_);
  std::cout << "\n" << std::flush;
  const int faults = print(diagnose(wanted, socketOf(wanted, target)));
  if (paused) {
    const bool starts = paused->resume();
    std::cout << (starts ? "The slamd service is started again.\n"
                         : "The slamd service does not start: journalctl -u slamd -n 50\n");
    return written && faults == 0 && starts;
  }
  if (written && faults == 0)
    std::cout << "Next: sudo systemctl enable --now slamd, or restart it; then slamctl status\n";
  return written && faults == 0;
}

}  // namespace slam
