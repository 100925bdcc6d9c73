// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace slam {

/// A serial port of this machine, as udev rules name it.
struct SerialPortInfo {
  std::string path;
  std::string description;  ///< vendor:product, product's name and serial number of a USB adapter
};
std::vector<SerialPortInfo> serialPorts();

/// The kernel's name (ttyUSB0) of the terminal behind a path, whatever that is called: a container or mknod may have
/// given it another. Found by its device number; empty where it is no terminal, or the kernel does not say.
/// @param sys where sysfs is
std::string ttyNameOf(const std::string& path, const std::filesystem::path& sys = "/sys");

/// Sets an open terminal to a line of 8N1 without flow control, whose bytes are passed on unchanged and as soon as they
/// come. Closing it does not drop DTR. @return what it refuses, static text; empty: nothing
const char* setSerialMode(int descriptor, int baud);

}  // namespace slam
