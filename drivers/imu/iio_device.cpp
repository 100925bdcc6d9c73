// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_device.hpp"

#include <array>
#include <cstdlib>
#include <fcntl.h>
#include <unistd.h>

#include "problems/devices.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

/// What a small file says; empty: it cannot be read.
std::string textOf(const fs::path& file) {
  std::array<char, 128> text;
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return {};
  const ssize_t size = ::read(descriptor, text.data(), text.size());
  ::close(descriptor);
  std::string all(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  all.erase(all.find_last_not_of(" \n") + 1);
  return all;
}

std::optional<double> numberOf(const fs::path& file) {
  const std::string text = textOf(file);
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') return std::nullopt;
  return number;
}

fs::path folderOf(const std::string& wanted, const fs::path& root) {
  if (wanted.starts_with('/')) return wanted;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(root, none)) {
    if (textOf(entry.path() / "name") == wanted) return entry.path();
  }
  return {};
}

}  // namespace

bool IioDevice::Axes::open(const fs::path& folder, const std::string& quantity) {
  std::error_code none;
  for (int i = 0; i < 3; ++i) {
    const std::string axis = quantity + "_" + "xyz"[i];
    raw[static_cast<std::size_t>(i)] = folder / (axis + "_raw");
    if (!fs::exists(raw[static_cast<std::size_t>(i)], none)) return false;
    // One for all axes, or one for each; none: 1 and 0.
    for (const std::string& of : {quantity, axis}) {
      scale[i] = numberOf(folder / (of + "_scale")).value_or(scale[i]);
      offset[i] = numberOf(folder / (of + "_offset")).value_or(offset[i]);
    }
  }
  return true;
}

bool IioDevice::Axes::read(Eigen::Vector3d& values) const {
  for (int i = 0; i < 3; ++i) {
    const auto number = numberOf(raw[static_cast<std::size_t>(i)]);
    if (!number) return false;
    values[i] = (*number + offset[i]) * scale[i];
  }
  return true;
}

std::optional<IioDevice> IioDevice::find(const std::string& wanted, Problem& problem, const fs::path& root) {
  const fs::path folder = folderOf(wanted, root);
  IioDevice device;
  device.name_ = textOf(folder / "name");
  if (folder.empty() || device.name_.empty()) {
    problem = {problem::kIioMissing, {}, {wanted}};
    return std::nullopt;
  }
  if (!device.gyro_.open(folder, "in_anglvel")) {
    problem = {problem::kIioNoGyro, {}, {device.name_}};
    return std::nullopt;
  }
  device.has_accel_ = device.accel_.open(folder, "in_accel");
  // Some chips are two devices: lsm6ds3_gyro and lsm6ds3_accel.
  std::string other = device.name_;
  if (const std::size_t at = other.rfind("gyro"); !device.has_accel_ && at != std::string::npos) {
    const fs::path beside = folderOf(other.replace(at, 4, "accel"), folder.parent_path());
    device.has_accel_ = !beside.empty() && device.accel_.open(beside, "in_accel");
  }
  return device;
}

}  // namespace slam
