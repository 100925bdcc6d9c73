// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

namespace slam::test {

/// A folder that stands for /sys/bus/iio/devices, with an MPU-6050 and a light sensor.
class IioFolder {
 public:
  IioFolder() {
    static int count = 0;
    root_ =
        std::filesystem::path(testing::TempDir()) / ("iio_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    plug();
    std::filesystem::create_directories(root_ / "iio:device0");
    std::ofstream(root_ / "iio:device0" / "name") << "tsl2561\n";
  }
  ~IioFolder() { std::filesystem::remove_all(root_); }

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path device() const { return root_ / "iio:device1"; }
  void set(const std::string& attribute, const std::string& text) const {
    // Renamed over the old one, so that nobody reads half of it.
    std::ofstream(root_ / "new") << text << '\n';
    std::filesystem::rename(root_ / "new", device() / attribute);
  }
  void remove(const std::string& attribute) const { std::filesystem::remove(device() / attribute); }
  void plug() const {
    std::filesystem::create_directories(device());
    set("name", "mpu6050");
    set("in_anglvel_scale", "0.001064724");
    set("in_accel_scale", "0.000598");
    for (const char* axis : {"x", "y", "z"}) {
      set(std::string("in_anglvel_") + axis + "_raw", "0");
      set(std::string("in_accel_") + axis + "_raw", "0");
    }
  }
  void unplug() const { std::filesystem::remove_all(device()); }

 private:
  std::filesystem::path root_;
};

}  // namespace slam::test
