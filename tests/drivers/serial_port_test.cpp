// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/serial_port.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libserialport.h>
#include <set>

#include "drivers/pseudo_terminal.hpp"
#include "support/modem_lines.hpp"

namespace slam::serial_port_test {
namespace {

using test::PseudoTerminal;

std::set<int> descriptors() {
  std::set<int> open;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::stoi(entry.path().filename());
    if (fcntl(descriptor, F_GETFD) >= 0) open.insert(descriptor);
  }
  return open;
}

/// @param lines whether the line has modem lines, as a serial port has, or none, as a pseudo-terminal
class SerialPortTest : public testing::TestWithParam<bool> {
 protected:
  SerialPortTest() { test::has_modem_lines = GetParam(); }
  ~SerialPortTest() override {
    test::has_modem_lines = false;
    close(watcher_);
  }

  termios mode() const {
    termios mode{};
    EXPECT_EQ(tcgetattr(watcher_, &mode), 0);
    return mode;
  }
  bool isShut() const {
    int shut = 0;
    EXPECT_EQ(ioctl(watcher_, TIOCGEXCL, &shut), 0);
    return shut != 0;
  }

  PseudoTerminal line_;
  const int watcher_ = ::open(line_.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
};
INSTANTIATE_TEST_SUITE_P(Lines, SerialPortTest, testing::Bool());

TEST_P(SerialPortTest, IsRawWhateverAnEarlierProgramLeft) {
  termios before{};
  before.c_iflag = ICRNL | INLCR | IGNCR | ISTRIP | IXON | IXOFF | IXANY | PARMRK | BRKINT | INPCK;
  before.c_oflag = OPOST | ONLCR;
  before.c_lflag = ICANON | ECHO | ISIG | IEXTEN;
  before.c_cflag = CS7 | CSTOPB | PARENB | PARODD | CRTSCTS | HUPCL | B9600;
  before.c_cc[VTIME] = 7;
  ASSERT_EQ(tcsetattr(watcher_, TCSANOW, &before), 0);
  SerialPort port;
  ASSERT_FALSE(port.open(line_.path(), 115200));
  const termios now = mode();
  EXPECT_EQ(now.c_iflag & (ICRNL | INLCR | IGNCR | ISTRIP | IXON | IXOFF | IXANY | PARMRK | BRKINT), 0U);
  EXPECT_EQ(now.c_oflag & OPOST, 0U);
  EXPECT_EQ(now.c_lflag & (ICANON | ECHO | ISIG | IEXTEN), 0U);
  EXPECT_EQ(now.c_cflag & (CSIZE | CSTOPB | PARENB | CRTSCTS), static_cast<tcflag_t>(CS8));
  EXPECT_EQ(now.c_cflag & HUPCL, 0U) << "closing would drop DTR";
  EXPECT_NE(now.c_cflag & CREAD, 0U);
  EXPECT_EQ(now.c_cc[VMIN], 1);
  EXPECT_EQ(now.c_cc[VTIME], 0);
}

TEST_P(SerialPortTest, IsShutToOthersAsLongAsItIsOpen) {
  {
    SerialPort port;
    ASSERT_FALSE(port.open(line_.path(), 115200));
    EXPECT_TRUE(isShut());
    const termios before = mode();
    ASSERT_EQ(ioctl(watcher_, TIOCNXCL), 0);
    SerialPort other;
    EXPECT_TRUE(other.open(line_.path(), 9600).is(problem::kPortInUse));
    EXPECT_EQ(mode().c_ospeed, before.c_ospeed) << "it is not the other's to set up";
  }
  EXPECT_FALSE(isShut()) << "although the line is still open elsewhere";
  SerialPort again;
  EXPECT_FALSE(again.open(line_.path(), 115200));
}

TEST_P(SerialPortTest, LeavesNoDescriptorBehindAndGivesNoneToAnotherProgram) {
  const std::set<int> before = descriptors();
  {
    SerialPort port;
    ASSERT_FALSE(port.open(line_.path(), 115200));
    for (const int descriptor : descriptors()) {
      EXPECT_TRUE(before.contains(descriptor) || (fcntl(descriptor, F_GETFD) & FD_CLOEXEC) != 0) << descriptor;
    }
    EXPECT_NE(fcntl(port.descriptor(), F_GETFL) & O_NONBLOCK, 0);
    SerialPort other;
    EXPECT_TRUE(other.open(line_.path(), 115200));
  }
  EXPECT_EQ(descriptors(), before);
}

TEST_P(SerialPortTest, SetsDtrWhereThereIsOne) {
  test::modem_lines = TIOCM_DTR | TIOCM_RTS;  // as the kernel raises them
  SerialPort port;
  ASSERT_FALSE(port.open(line_.path(), 256000));
  EXPECT_EQ(test::modem_lines, TIOCM_DTR | TIOCM_RTS);
  const termios before = mode();
  EXPECT_EQ(port.setDtr(false), GetParam());
  EXPECT_EQ(test::modem_lines, GetParam() ? TIOCM_RTS : TIOCM_DTR | TIOCM_RTS);
  EXPECT_EQ(port.setDtr(true), GetParam());
  EXPECT_EQ(test::modem_lines, TIOCM_DTR | TIOCM_RTS);
  EXPECT_EQ(mode().c_cflag, before.c_cflag);
  EXPECT_EQ(mode().c_ospeed, before.c_ospeed);
}

/// What a second handle of libserialport on the same line reads.
class Reader {
 public:
  explicit Reader(int descriptor) {
    const std::string name = "/dev/../../../proc/self/fd/" + std::to_string(descriptor);
    EXPECT_EQ(sp_get_port_by_name(name.c_str(), &port_), SP_OK);
    EXPECT_EQ(sp_open(port_, SP_MODE_READ), SP_OK);
    EXPECT_EQ(sp_new_config(&config_), SP_OK);
  }
  ~Reader() {
    sp_free_config(config_);
    sp_close(port_);
    sp_free_port(port_);
  }
  const sp_port_config* read() {
    EXPECT_EQ(sp_get_config(port_, config_), SP_OK);
    return config_;
  }

 private:
  sp_port* port_ = nullptr;
  sp_port_config* config_ = nullptr;
};

TEST(SerialPort, IsAtTheBaudRateThatLibserialportReads) {
  test::has_modem_lines = true;
  {
    PseudoTerminal line;
    const int watcher = ::open(line.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    Reader reader(watcher);  // before the port, which shuts others out
    for (const int baud : {9600, 115200, 128000, 256000, 921600, 1000000, 123457}) {
      SerialPort port;
      ASSERT_FALSE(port.open(line.path(), baud));
      const sp_port_config* config = reader.read();
      int number = 0;
      sp_get_config_baudrate(config, &number);
      EXPECT_EQ(number, baud);
      sp_get_config_bits(config, &number);
      EXPECT_EQ(number, 8);
      sp_get_config_stopbits(config, &number);
      EXPECT_EQ(number, 1);
      sp_parity parity{};
      sp_get_config_parity(config, &parity);
      EXPECT_EQ(parity, SP_PARITY_NONE);
      sp_xonxoff software{};
      sp_get_config_xon_xoff(config, &software);
      EXPECT_EQ(software, SP_XONXOFF_DISABLED);
      sp_rts rts{};
      sp_get_config_rts(config, &rts);
      EXPECT_NE(rts, SP_RTS_FLOW_CONTROL);
    }
    ::close(watcher);
  }
  test::has_modem_lines = false;
}

}  // namespace
}  // namespace slam::serial_port_test
