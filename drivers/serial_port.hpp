// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "drivers/byte_stream.hpp"

namespace slam {

/// A serial port of this machine, as udev rules name it.
struct SerialPortInfo {
  std::string path;
  std::string description;  ///< vendor:product, product's name and serial number of a USB adapter
};
std::vector<SerialPortInfo> serialPorts();

/// Does libserialport know this path (or the target of this link) as a serial port?
bool isSerialPort(const std::string& path);

/// Opens a real serial port through libserialport.
OpenedPort openSerialPort(const std::string& path, int baud);

}  // namespace slam
