// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/serial_port.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <libserialport.h>
#include <termios.h>

namespace slam {
namespace {

struct PortDeleter {
  void operator()(sp_port* port) const {
    sp_close(port);
    sp_free_port(port);
  }
};
using Port = std::unique_ptr<sp_port, PortDeleter>;

class SerialPort : public ByteStream {
 public:
  SerialPort(Port port, int descriptor) : port_(std::move(port)), descriptor_(descriptor) {}

  bool write(std::span<const std::uint8_t> bytes) override {
    const int n = sp_nonblocking_write(port_.get(), bytes.data(), bytes.size());
    return n == static_cast<int>(bytes.size());
  }
  void discardInput() override { sp_flush(port_.get(), SP_BUF_INPUT); }
  bool setDtr(bool on) override { return sp_set_dtr(port_.get(), on ? SP_DTR_ON : SP_DTR_OFF) == SP_OK; }

 protected:
  int descriptor() const override { return descriptor_; }
  int take(std::span<std::uint8_t> out) override {
    const int n = sp_nonblocking_read(port_.get(), out.data(), out.size());
    return n < 0 ? -1 : n;
  }

 private:
  Port port_;
  int descriptor_;
};

/// udev's stable names are links, which libserialport does not follow.
std::string resolved(const std::string& path) {
  std::error_code error;
  const auto target = std::filesystem::canonical(path, error);
  return error ? path : target.string();
}

}  // namespace

bool isSerialPort(const std::string& path) {
  sp_port* port = nullptr;
  if (sp_get_port_by_name(resolved(path).c_str(), &port) != SP_OK) return false;
  sp_free_port(port);
  return true;
}

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

OpenedPort openSerialPort(const std::string& path, int baud) {
  sp_port* raw = nullptr;
  if (sp_get_port_by_name(resolved(path).c_str(), &raw) != SP_OK)
    return {nullptr, "no such port: check cable and udev rule"};
  Port port(raw);
  if (sp_open(raw, SP_MODE_READ_WRITE) != SP_OK) {
    if (errno == EACCES) return {nullptr, "no right to open the port: add the user to group dialout"};
    if (errno == EBUSY) return {nullptr, "the port is in use by another program"};
    return {nullptr, "the port cannot be opened"};
  }
  int fd = -1;
  const bool set = sp_set_baudrate(raw, baud) == SP_OK && sp_set_bits(raw, 8) == SP_OK &&
                   sp_set_parity(raw, SP_PARITY_NONE) == SP_OK && sp_set_stopbits(raw, 1) == SP_OK &&
                   sp_set_flowcontrol(raw, SP_FLOWCONTROL_NONE) == SP_OK && sp_get_port_handle(raw, &fd) == SP_OK;
  if (!set) return {nullptr, "the port refuses its settings: check the baud rate"};
  if (!lockPort(fd)) return {nullptr, "the port is in use by another program"};  // 0.1.1 does not lock it itself
  termios mode{};
  if (tcgetattr(fd, &mode) == 0) {
    mode.c_cflag &= ~static_cast<tcflag_t>(HUPCL);  // else closing drops DTR, and an A1's motor spins again
    tcsetattr(fd, TCSANOW, &mode);
  }
  return {std::make_unique<SerialPort>(std::move(port), fd), ""};
}

}  // namespace slam
