// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "vm/machine.hpp"

namespace slam::test {

/// A virtual robot: Debian 12 with systemd on a disk of its own, and slam-sim in place of the devices.
class Robot {
 public:
  static constexpr int kMemory = 512;  // [MB]

  /// Makes an empty disk. @param folder of all that belongs to this robot
  /// @return Machine::kSkipped where one cannot be had, 0: made; problem() has the words
  int prepare(const std::filesystem::path& folder) {
    folder_ = folder;
    for (const char* step : {"prepare_kernel", "prepare_root"}) {
      if (const int status = runScript({kSource + step, kKernel}, 300); status != 0) return status;
    }
    if (const int status =
            runScript({kSource + "make_initrd", folder / "initrd.gz", kKernel, kSource + "guest/switch_root"}, 60);
        status != 0) {
      return status;
    }
    return runScript({"cp", "--sparse=always", "--reflink=auto", kKernel + "/root.img", disk()}, 60);
  }

  /// @return false where out/ has none of slamd that is as new as this build; problem() has the words
  bool hasPackage() { return runScript({kSource + "make_delivery", "--package", kKernel + "/.."}, 60) == 0; }

  /// Chooses what the next boot runs. @param scenario in guest/robot @param delivery further files, put beside it
  bool choose(const std::string& scenario, const std::vector<std::string>& delivery = {}) {
    std::vector<std::string> make = {kSource + "make_delivery", folder_ / "delivery.tar", scenario};
    make.insert(make.end(), delivery.begin(), delivery.end());
    return runScript(make, 60) == 0;
  }

  /// @param drive the disk as QEMU's argument of -drive; empty: plainly
  std::unique_ptr<Machine> boot(std::string drive = {}) const {
    if (drive.empty()) drive = "driver=raw,file.filename=" + disk().string();
    // No login on the console, and none of the services that a robot without D-Bus tries in vain.
    const std::string parameters =
        "net.ifnames=0 systemd.show_status=0 systemd.mask=serial-getty@ttyS0.service systemd.mask=getty@tty1.service "
        "systemd.mask=systemd-logind.service";
    return std::make_unique<Machine>(folder_, kKernel, folder_ / "initrd.gz", kMemory, parameters,
                                     std::vector<std::string>{"-drive", drive + ",if=virtio", "-drive",
                                                              "driver=raw,if=virtio,read-only=on,file.filename=" +
                                                                  (folder_ / "delivery.tar").string()},
                                     Machine::GuestTime::kAtLeastInstructions);
  }

  std::filesystem::path disk() const { return folder_ / "disk.img"; }
  const std::string& problem() const { return problem_; }

 private:
  int runScript(const std::vector<std::string>& command, int limit) {
    const std::filesystem::path output = folder_ / "prepare.txt";
    const auto status = Process(command, output).wait(std::chrono::seconds(limit));
    std::ifstream in(output);
    std::ostringstream text;
    text << command.front() << ": " << in.rdbuf();
    problem_ = text.str();
    return status.value_or(1);
  }

  inline static const std::string kSource = SLAMD_SOURCE_DIR "/tests/vm/";
  inline static const std::string kKernel = SLAMD_BINARY_DIR "/../vm";
  std::filesystem::path folder_;
  std::string problem_;
};

}  // namespace slam::test
