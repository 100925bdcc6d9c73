// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/fault_script.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace slam::sim {
namespace {

constexpr std::array<std::string_view, 5> kDevices = {"lidar", "board", "imu", "depth", "can"};
constexpr std::size_t kLongestLine = 1000;

[[noreturn]] void failToRead(const std::filesystem::path& path) {
  throw std::system_error(errno, std::generic_category(), path.string());
}

}  // namespace

std::optional<Fault> parseFault(std::string_view text) {
  std::istringstream words{std::string(text)};
  Fault fault;
  if (!(words >> fault.device >> fault.kind)) return std::nullopt;
  if (std::find(kDevices.begin(), kDevices.end(), fault.device) == kDevices.end()) return std::nullopt;
  std::string more;
  if (words >> more) {
    std::size_t used = 0;
    try {
      fault.value = std::stod(more, &used);
    } catch (const std::exception&) {
      return std::nullopt;
    }
    if (used != more.size() || words >> more) return std::nullopt;
  }
  return fault;
}

std::vector<ScheduledFault> readFaultScript(std::istream& in, const std::string& name) {
  std::vector<ScheduledFault> script;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    double seconds = -1.0;
    words >> seconds;
    std::string rest;
    std::getline(words, rest);
    const auto fault = parseFault(rest);
    if (!(seconds >= 0.0 && seconds < 1e7) || !fault) {
      throw std::runtime_error(name + ":" + std::to_string(number) +
                               ": no fault; write SECONDS DEVICE KIND [VALUE], e.g. 12.5 lidar unplug 1");
    }
    script.push_back({fromSeconds(seconds), *fault, number});
  }
  std::stable_sort(script.begin(), script.end(),
                   [](const ScheduledFault& a, const ScheduledFault& b) { return a.at < b.at; });
  return script;
}

FaultPipe::FaultPipe(const std::filesystem::path& path) : path_(path) {
  std::filesystem::create_directories(path.parent_path());
  unlink(path.c_str());
  if (mkfifo(path.c_str(), 0600) != 0) failToRead(path);
  descriptor_ = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);  // O_RDWR: never at its end without a writer
  if (descriptor_ < 0) failToRead(path);
}

FaultPipe::~FaultPipe() {
  close(descriptor_);
  unlink(path_.c_str());
}

std::vector<std::string> FaultPipe::read() {
  std::array<char, 512> chunk;
  for (ssize_t n; (n = ::read(descriptor_, chunk.data(), chunk.size())) > 0;) {
    rest_.append(chunk.data(), static_cast<std::size_t>(n));
    if (rest_.size() > kLongestLine && rest_.find('\n') == std::string::npos) rest_.clear();
  }
  std::vector<std::string> lines;
  for (std::size_t end; (end = rest_.find('\n')) != std::string::npos; rest_.erase(0, end + 1)) {
    lines.push_back(rest_.substr(0, end));
  }
  return lines;
}

FaultQueue::FaultQueue(const std::filesystem::path& script, const std::filesystem::path& pipe) : pipe_(pipe) {
  if (script.empty()) return;
  std::ifstream in(script);
  if (!in) throw std::runtime_error(script.string() + ": cannot be read");
  script_ = readFaultScript(in, script.string());
}

void FaultQueue::collect(Duration elapsed) {
  const std::lock_guard lock(mutex_);
  for (; next_ < script_.size() && script_[next_].at <= elapsed; ++next_) due_.push_back(script_[next_].fault);
  for (const std::string& line : pipe_.read()) {
    if (const auto fault = parseFault(line)) {
      due_.push_back(*fault);
    } else {
      std::fprintf(stderr, "slam-sim: no fault: %s; write DEVICE KIND [VALUE]\n", line.c_str());
    }
  }
}

void FaultQueue::deliver(std::string_view device, const std::function<bool(const Fault&)>& inject) {
  std::vector<Fault> taken;
  {
    const std::lock_guard lock(mutex_);
    const auto others =
        std::stable_partition(due_.begin(), due_.end(), [&](const Fault& fault) { return fault.device == device; });
    taken.assign(due_.begin(), others);
    due_.erase(due_.begin(), others);
  }
  for (const Fault& fault : taken) {
    if (inject(fault)) continue;
    std::fprintf(stderr, "slam-sim: the %s knows no fault \"%s\" of %g\n", fault.device.c_str(), fault.kind.c_str(),
                 fault.value);
  }
}

}  // namespace slam::sim
