// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/serial_port.hpp"

#include <array>
#include <asm/termbits.h>  // termios2, for any baud rate; it excludes <termios.h>
#include <cstdio>
#include <libserialport.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <system_error>

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

const char* setSerialMode(int descriptor, int baud) {
  struct termios2 mode {};
  if (ioctl(descriptor, TCGETS2, &mode) != 0) return "not a serial port: check the path";
  mode.c_iflag &=
      ~static_cast<tcflag_t>(IGNBRK | BRKINT | PARMRK | INPCK | ISTRIP | INLCR | IGNCR | ICRNL | IXON | IXOFF | IXANY);
  mode.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  mode.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
  // Without HUPCL: else closing drops DTR, and an A1's motor spins again.
  mode.c_cflag &= ~static_cast<tcflag_t>(CSIZE | CSTOPB | PARENB | CRTSCTS | HUPCL | CBAUD | CBAUD << IBSHIFT);
  mode.c_cflag |= CS8 | CREAD | CLOCAL | BOTHER | static_cast<tcflag_t>(BOTHER) << IBSHIFT;
  mode.c_ispeed = mode.c_ospeed = static_cast<speed_t>(baud);
  mode.c_cc[VMIN] = 1;  // a read without data fails with EAGAIN: 0 bytes are a hang-up
  mode.c_cc[VTIME] = 0;
  if (ioctl(descriptor, TCSETS2, &mode) != 0) return "the port refuses its settings: check the baud rate";
  struct serial_struct serial {};  // where an adapter or UART holds bytes back; many have no such setting
  if (ioctl(descriptor, TIOCGSERIAL, &serial) == 0 && (serial.flags & ASYNC_LOW_LATENCY) == 0) {
    serial.flags |= ASYNC_LOW_LATENCY;
    ioctl(descriptor, TIOCSSERIAL, &serial);
  }
  return "";
}

}  // namespace slam
