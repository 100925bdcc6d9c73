// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_recording.hpp"

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "config/file_edit.hpp"
#include "tools/common/output_file.hpp"
#include "tools/slamctl/setup/drive_progress.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kLook = 500ms;             // between two looks at what was recorded
constexpr auto kBegin = 40s;              // for the first scans and wheels: a lidar may be looked for and spun up
constexpr auto kEnd = 20s;                // for the log to be written
constexpr std::size_t kLastWords = 1500;  // [bytes] of what slamd printed

/// slamd beside this program, or of the path.
std::string slamdProgram() {
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error);
  const fs::path beside = own.parent_path() / "slamd";
  return !error && fs::exists(beside) ? beside.string() : "slamd";
}

std::string lastWordsIn(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  const std::string all = text.str();
  return all.size() > kLastWords ? all.substr(all.size() - kLastWords) : all;
}

/// A slamd that ends with this program.
class Slamd {
 public:
  Slamd(const fs::path& config, const fs::path& words) {
    const std::string program = slamdProgram();
    std::vector<std::string> arguments{program, "--config", config.string()};
    std::vector<char*> list;
    for (std::string& argument : arguments) list.push_back(argument.data());
    list.push_back(nullptr);
    const pid_t parent = getpid();
    id_ = fork();
    if (id_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    close_range(3, ~0U, 0);  // connections of the set-up's page
    const int file = open(words.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    execvp(list[0], list.data());
    _exit(127);
  }
  ~Slamd() { end(); }
  Slamd(const Slamd&) = delete;
  Slamd& operator=(const Slamd&) = delete;

  bool runs() {
    if (id_ > 0 && waitpid(id_, nullptr, WNOHANG) == id_) id_ = -1;
    return id_ > 0;
  }
  void end() {
    if (id_ > 0) kill(id_, SIGTERM);
    for (const auto limit = Clock::now() + kEnd; runs() && Clock::now() < limit;) std::this_thread::sleep_for(20ms);
    if (!runs()) return;
    kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
    id_ = -1;
  }

 private:
  pid_t id_ = -1;
};

/// The same robot, with nothing kept but the record.
Config forRecording(Config config, const fs::path& log) {
  config.mode = RunMode::kSlam;
  config.store = {};
  config.output = {.map = "", .record = log.string()};
  config.log = {};
  config.log.automatic = false;
  config.runtime.socket.clear();
  config.web = {};
  config.depth_device.driver = DepthDriver::kNone;
  return config;
}

}  // namespace

fs::path recordDrive(const Config& config, double seconds, const fs::path& folder, Console& console) {
  const fs::path file = folder / "slamd.toml", words = folder / "slamd.txt", log = folder / "drive.lcm";
  OutputFile written(file);
  written.write(editedConfig("", forRecording(config, log)));
  written.close();
  Slamd slamd(file, words);
  DriveWatch watch(log);
  std::optional<Clock::time_point> begin;
  const auto started = Clock::now(), limit = started + kBegin;
  DriveProgress progress{.length = seconds};
  while (progress.seconds < seconds) {
    std::this_thread::sleep_for(kLook);
    if (!slamd.runs()) throw std::runtime_error("slamd ended before the drive did:\n" + lastWordsIn(words));
    watch.look();
    const bool begins = !begin && watch.hasSensors();
    if (begins) begin = Clock::now();
    if (!begin && Clock::now() > limit)
      throw std::runtime_error("no scans, or no wheels, came for the calibration:\n" + lastWordsIn(words));
    if (!begin) continue;
    progress = watch.driven();
    progress.phase = begins ? DriveProgress::kBegins : DriveProgress::kDrives;
    progress.seconds = std::chrono::duration<double>(Clock::now() - *begin).count();
    progress.length = seconds;
    console.show(progress);
  }
  progress.phase = DriveProgress::kOver;
  console.show(progress);
  slamd.end();
  return log;
}

}  // namespace slam
