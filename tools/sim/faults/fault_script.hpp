// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <istream>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// Something that goes wrong with a device, or right again.
struct Fault {
  std::string device;  ///< "lidar", "board", "imu", "depth", "can"
  std::string kind;    ///< what the device's emulator or its line knows
  double value = 1.0;
};

struct ScheduledFault {
  Duration at{0};  ///< since the devices began to play
  Fault fault;
  int line = 0;  ///< of the script
};

/// `DEVICE KIND [VALUE]`, VALUE 1 where it is left out. @return std::nullopt for anything else
std::optional<Fault> parseFault(std::string_view text);

/// One fault a line, `SECONDS DEVICE KIND [VALUE]`, in any order; # begins a comment.
/// @return by time @throws std::runtime_error `name:line: what; fix`
std::vector<ScheduledFault> readFaultScript(std::istream& in, const std::string& name);

/// A named pipe that takes faults at run time: `echo "lidar unplug 1" > DIR/faults`.
class FaultPipe {
 public:
  /// @throws std::system_error when the pipe cannot be made
  explicit FaultPipe(const std::filesystem::path& path);
  ~FaultPipe();
  FaultPipe(const FaultPipe&) = delete;
  FaultPipe& operator=(const FaultPipe&) = delete;

  /// Whole lines that were written since the last call. Does not wait.
  std::vector<std::string> read();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::string rest_;  // of an unfinished line
};

/// Faults that are due, by a script or by a pipe, until their devices take them. Safe from any thread.
class FaultQueue {
 public:
  /// @param script a file; empty: none @throws std::runtime_error, std::system_error as the above
  FaultQueue(const std::filesystem::path& script, const std::filesystem::path& pipe);

  /// @param elapsed since the devices began to play
  void collect(Duration elapsed);
  /// Hands a device its faults that are due. @param inject returns false for one that it does not know
  void deliver(std::string_view device, const std::function<bool(const Fault&)>& inject);

 private:
  std::mutex mutex_;
  std::vector<ScheduledFault> script_;
  std::size_t next_ = 0;  // of the script
  FaultPipe pipe_;
  std::vector<Fault> due_;
};

}  // namespace slam::sim
