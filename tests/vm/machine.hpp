// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <vector>

#include "build_paths.hpp"
#include "support/process.hpp"

namespace slam::test {

/// Connects to a socket that QEMU listens on. @return descriptor, -1 when it is not there yet
inline int connectTo(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

/// A virtual machine with Debian's kernel, without hardware virtualisation.
class Machine {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kSkipped = 77;
  enum class GuestTime {
    kOfTheHost,            ///< for what the host takes part in; an emulated machine is slow by it
    kInstructions,         ///< 2 ns for each instruction, none while it waits: as fast in its own eyes on any host
    kAtLeastInstructions,  ///< 1 ns for each instruction, and it waits as long as the host does: it waits for a disk
  };

  /// Boots into `scenario`. @param kernel folder that prepare_kernel filled
  /// @param programs with the libraries they need, in /real
  /// @param devices further arguments of QEMU
  /// @param time what the guest's clocks count
  Machine(const std::filesystem::path& folder, const std::string& kernel, const std::string& scenario,
          const std::vector<std::string>& programs, const std::vector<std::string>& devices, GuestTime time)
      : folder_(folder) {
    const std::string source = SLAMD_SOURCE_DIR "/tests/vm/";
    std::vector<std::string> make = {source + "make_initrd", folder / "initrd.gz", kernel, source + "guest/init",
                                     source + "guest/" + scenario};
    make.insert(make.end(), programs.begin(), programs.end());
    if (Process(make, folder / "make.txt").wait(std::chrono::seconds(60)) != 0) {
      problem_ = "make_initrd: " + read(folder / "make.txt");
      return;
    }
    boot(kernel, folder / "initrd.gz", "384", "", devices, time);
  }

  /// Boots the system that is on a disk.
  /// @param initrd that hands over to it @param memory [MB] @param parameters of the kernel
  Machine(const std::filesystem::path& folder, const std::string& kernel, const std::filesystem::path& initrd,
          int memory, const std::string& parameters, const std::vector<std::string>& devices, GuestTime time)
      : folder_(folder) {
    boot(kernel, initrd, std::to_string(memory), parameters, devices, time);
  }

  /// Polls until the console shows the text, doing `meanwhile` between. @return [s] it took, nullopt: not in time
  std::optional<double> waitFor(const std::string& text, std::chrono::seconds limit,
                                const std::function<void()>& meanwhile = {}) {
    const auto begin = Clock::now();
    for (std::optional<int> over; problem_.empty() && qemu_;) {
      if (console().find(text, seen_) != std::string::npos) {
        return std::chrono::duration<double>(Clock::now() - begin).count();
      }
      if (over || Clock::now() - begin > limit) break;
      over = qemu_->wait(std::chrono::milliseconds(meanwhile ? 0 : 50));
      if (meanwhile) meanwhile();
    }
    return std::nullopt;
  }
  /// What comes from now on is looked at by waitFor().
  void forget() { seen_ = console().size(); }

  /// @return what /scenario ended with; nullopt when it did not in time
  std::optional<int> exitStatus(std::chrono::seconds limit, const std::function<void()>& meanwhile = {}) {
    seen_ = 0;
    if (!waitFor("VM-EXIT ", limit, meanwhile)) return std::nullopt;
    usleep(100000);  // the number may still be on its way
    const std::string text = console();
    return std::stoi(text.substr(text.find("VM-EXIT ") + 8));
  }

  /// Cuts the power.
  void kill() { qemu_.reset(); }

  /// A command of QEMU's monitor.
  bool monitor(const std::string& command) {
    if (monitor_ < 0) monitor_ = connectTo(folder_ / "monitor");
    const std::string line = command + "\n";
    return write(monitor_, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  }
  ~Machine() {
    if (monitor_ >= 0) close(monitor_);
  }
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  std::string console() const { return read(folder_ / "console.txt"); }
  std::string report() const { return problem_ + "\n" + read(folder_ / "qemu.txt") + "\n" + console(); }

 private:
  void boot(const std::string& kernel, const std::string& initrd, const std::string& memory,
            const std::string& parameters, const std::vector<std::string>& devices, GuestTime time) {
    std::vector<std::string> run = {"qemu-system-x86_64",
                                    "-accel",
                                    "tcg",
                                    "-M",
                                    "pc",
                                    "-m",
                                    memory,
                                    "-smp",
                                    "1",
                                    "-display",
                                    "none",
                                    "-no-reboot",
                                    "-nodefaults",
                                    "-chardev",
                                    "file,id=console,path=" + (folder_ / "console.txt").string(),
                                    "-serial",
                                    "chardev:console",
                                    "-chardev",
                                    "socket,id=monitor,server=on,wait=off,path=" + (folder_ / "monitor").string(),
                                    "-mon",
                                    "chardev=monitor,mode=readline",
                                    "-kernel",
                                    kernel + "/vmlinux",
                                    "-initrd",
                                    initrd,
                                    "-append",
                                    "console=ttyS0 quiet panic=-1 " + parameters};
    if (time == GuestTime::kInstructions) {
      run.insert(run.end(), {"-icount", "shift=1,sleep=off", "-rtc", "clock=vm"});
    } else if (time == GuestTime::kAtLeastInstructions) {
      run.insert(run.end(), {"-icount", "shift=0,sleep=on", "-rtc", "clock=vm"});
    }
    run.insert(run.end(), devices.begin(), devices.end());
    std::filesystem::remove(folder_ / "console.txt");  // of a machine before this one
    qemu_.emplace(run, folder_ / "qemu.txt");
  }

  static std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

  std::filesystem::path folder_;
  std::string problem_;
  std::optional<Process> qemu_;
  int monitor_ = -1;
  std::size_t seen_ = 0;  // of the console
};

}  // namespace slam::test
