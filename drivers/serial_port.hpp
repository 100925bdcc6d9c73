// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

struct sp_port;

#include "problems/devices.hpp"

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

/// An open serial port. libserialport opens it, sets it up, sets its modem lines, empties and closes it. Its owner
/// waits, reads and writes by descriptor(): a wait within the library is poll(), which waits for a kernel thread of
/// normal priority.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Opens it without waiting for a carrier, for this process alone, as a line of 8N1 without flow control, whose bytes
  /// are passed on unchanged and as soon as they come. Closing it does not drop DTR. Once.
  /// @param baud [bit/s] any that its adapter can @return why not; none: it is open
  Problem open(const std::string& path, int baud);
  int descriptor() const { return handle_; }
  void discardInput();
  /// @return false where it has no modem lines
  bool setDtr(bool on);

 private:
  Problem openBehindNode(int baud);
  bool setUpByHand(int baud);

  int node_ = -1;            // holds the lock, and the device while libserialport opens it
  int handle_ = -1;          // of port_, or node_
  sp_port* port_ = nullptr;  // nullptr: a pseudo-terminal, or another terminal without modem lines
};

}  // namespace slam
