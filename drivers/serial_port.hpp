// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "drivers/byte_stream.hpp"

namespace slam {

/// Does libserialport know this path (or the target of this link) as a serial port?
bool isSerialPort(const std::string& path);

/// Opens a real serial port through libserialport.
OpenedPort openSerialPort(const std::string& path, int baud);

}  // namespace slam
