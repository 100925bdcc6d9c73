// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/serial_port.hpp"

#include <array>
#include <asm/termbits.h>  // termios2, for any baud rate; it excludes <termios.h>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <libserialport.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <system_error>
#include <unistd.h>

#include "drivers/open_problem.hpp"
#include "drivers/search/port_holder.hpp"

namespace slam {

std::vector<SerialPortInfo> serialPorts() {
  std::vector<SerialPortInfo> found;
  sp_port** list = nullptr;
  if (sp_list_ports(&list) != SP_OK) return found;
  for (sp_port** port = list; *port != nullptr; ++port) {
    SerialPortInfo info{sp_get_port_name(*port), ""};
    int vendor = 0, product = 0;
    if (sp_get_port_usb_vid_pid(*port, &vendor, &product) == SP_OK) {
      std::array<char, 16> ids{};
      std::snprintf(ids.data(), ids.size(), "%04x:%04x", static_cast<unsigned>(vendor), static_cast<unsigned>(product));
      info.description = ids.data();
    }
    for (const char* text : {sp_get_port_usb_product(*port), sp_get_port_usb_serial(*port)}) {
      if (text != nullptr) info.description += std::string(info.description.empty() ? "" : " ") + text;
    }
    found.push_back(std::move(info));
  }
  sp_free_port_list(list);
  return found;
}

std::string ttyNameOf(const std::string& path, const std::filesystem::path& sys) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || !S_ISCHR(status.st_mode)) return "";
  const std::string number = std::to_string(major(status.st_rdev)) + ":" + std::to_string(minor(status.st_rdev));
  std::error_code error;
  const auto device = std::filesystem::canonical(sys / "dev" / "char" / number, error);
  return error || device.parent_path().filename() != "tty" ? "" : device.filename().string();
}

SerialPort::~SerialPort() {
  if (handle_ >= 0) ioctl(handle_, TIOCNXCL);  // a pseudo-terminal whose other end is open would stay shut
  if (port_ != nullptr) {
    sp_close(port_);
    sp_free_port(port_);
  }
  if (node_ >= 0) close(node_);
}

Problem SerialPort::open(const std::string& path, int baud) {
  node_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (node_ < 0) {
    const int error = errno;
    return error == EBUSY ? portInUse(path) : openProblem(error, rightsOf(path));
  }
  if (isatty(node_) == 0) return problem::kPortIsNone;
  if (flock(node_, LOCK_EX | LOCK_NB) != 0) return portInUse(path);
  handle_ = node_;
  int lines = 0;
  if (ioctl(node_, TIOCMGET, &lines) == 0) {
    if (const Problem problem = openBehindNode(baud)) return problem;
  }
  if (!setUpByHand(baud)) return problem::kPortRefusesSettings;
  ioctl(handle_, TIOCEXCL);  // keeps others out who know no flock(), but not root
  return {};
}

Problem SerialPort::openBehindNode(int baud) {
  // libserialport 0.1.1 looks for a name in sysfs before it opens it, and there is none of a link of udev's or of a
  // container's node. This one exists on both ways, seen from /dev and from /sys/class/tty.
  const std::string name = "/dev/../../../proc/self/fd/" + std::to_string(node_);
  if (sp_get_port_by_name(name.c_str(), &port_) != SP_OK) return problem::kPortUnknown;
  if (sp_open(port_, SP_MODE_READ_WRITE) != SP_OK) return openProblem(sp_last_error_code(), {});
  sp_get_port_handle(port_, &handle_);
  fcntl(handle_, F_SETFD, FD_CLOEXEC);
  sp_port_config* config = nullptr;  // what is not set stays: DTR and RTS as the kernel raises them
  if (sp_new_config(&config) != SP_OK) return problem::kPortRefusesSettings;
  sp_set_config_baudrate(config, baud);
  sp_set_config_bits(config, 8);
  sp_set_config_parity(config, SP_PARITY_NONE);
  sp_set_config_stopbits(config, 1);
  sp_set_config_flowcontrol(config, SP_FLOWCONTROL_NONE);
  const bool is_set = sp_set_config(port_, config) == SP_OK;
  sp_free_config(config);
  return is_set ? Problem() : problem::kPortRefusesSettings;
}

/// What libserialport 0.1.1 leaves as it was; and all of it where there are no modem lines, for there it refuses to
/// open.
bool SerialPort::setUpByHand(int baud) {
  struct termios2 mode {};
  if (ioctl(handle_, TCGETS2, &mode) != 0) return false;
  if (port_ == nullptr) {
    mode.c_iflag &= ~static_cast<tcflag_t>(IGNBRK | BRKINT | PARMRK | INPCK | ISTRIP | INLCR | IGNCR | ICRNL | IXON |
                                           IXOFF | IXANY);
    mode.c_oflag &= ~static_cast<tcflag_t>(OPOST);
    mode.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
    mode.c_cflag &= ~static_cast<tcflag_t>(CSIZE | CSTOPB | PARENB | CBAUD | CBAUD << IBSHIFT);
    mode.c_cflag |= CS8 | CREAD | CLOCAL | BOTHER | static_cast<tcflag_t>(BOTHER) << IBSHIFT;
    mode.c_ispeed = mode.c_ospeed = static_cast<speed_t>(baud);
  }
  // Without HUPCL: else closing drops DTR, and an A1's motor spins again.
  mode.c_cflag &= ~static_cast<tcflag_t>(HUPCL | CRTSCTS);
  mode.c_cc[VMIN] = 1;  // a read without data fails with EAGAIN: 0 bytes are a hang-up
  mode.c_cc[VTIME] = 0;
  if (ioctl(handle_, TCSETS2, &mode) != 0) return false;
  serial_struct serial{};  // where an adapter or UART holds bytes back; many have no such setting
  if (ioctl(handle_, TIOCGSERIAL, &serial) == 0 && (serial.flags & ASYNC_LOW_LATENCY) == 0) {
    serial.flags |= ASYNC_LOW_LATENCY;
    ioctl(handle_, TIOCSSERIAL, &serial);
  }
  return true;
}

void SerialPort::discardInput() {
  if (port_ != nullptr) {
    sp_flush(port_, SP_BUF_INPUT);
  } else {
    ioctl(handle_, TCFLSH, TCIFLUSH);
  }
}

bool SerialPort::setDtr(bool on) { return port_ != nullptr && sp_set_dtr(port_, on ? SP_DTR_ON : SP_DTR_OFF) == SP_OK; }

}  // namespace slam
