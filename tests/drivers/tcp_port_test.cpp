// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/tcp_port.hpp"

#include <array>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/sim/tcp_server.hpp"

namespace slam::tcp_port_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

std::string at(std::uint16_t port) { return "tcp://127.0.0.1:" + std::to_string(port); }

TEST(TcpAddress, IsANumberAndAPort) {
  const auto address = parseTcp("tcp://192.168.0.10:10940");
  ASSERT_TRUE(address);
  EXPECT_EQ(address->host, "192.168.0.10");
  EXPECT_EQ(address->port, 10940);
  EXPECT_EQ(parseTcp("tcp://[::1]:2112")->host, "::1");
  for (const char* wrong : {"tcp://", "tcp://192.168.0.10", "tcp://192.168.0.10:", "tcp://192.168.0.10:0",
                            "tcp://192.168.0.10:65536", "tcp://192.168.0.10:2112x", "tcp://lidar:2112",
                            "tcp://192.168.0:2112", "tcp://::1:2112", "tcp://[::1:2112", "/dev/lidar", ""})
    EXPECT_FALSE(parseTcp(wrong)) << wrong;
}

TEST(TcpPort, CarriesBytesBothWaysAndHangsUp) {
  auto server = std::make_unique<sim::TcpServer>(0);
  const std::string path = at(server->port());
  OpenedPort port = openPort(path, 115200);
  ASSERT_TRUE(port.stream) << port.problem.words();
  std::array<std::uint8_t, 16> bytes{};
  EXPECT_EQ(server->read(bytes, 2s), 0U) << "it lets the program in";
  ASSERT_TRUE(port.stream->write(std::array<std::uint8_t, 2>{1, 2}));
  ASSERT_EQ(server->read(bytes, 2s), 2U);
  EXPECT_EQ(bytes[1], 2);
  server->send(std::array<std::uint8_t, 1>{7});
  ASSERT_EQ(port.stream->read(bytes, 2s).size, 1U);
  EXPECT_EQ(bytes[0], 7);
  server->send(std::array<std::uint8_t, 1>{8});  // and at once the end: what came before it is read
  server.reset();
  ReadResult last = port.stream->read(bytes, 2s);
  EXPECT_EQ(last.size, 1U);
  last = port.stream->read(bytes, 2s);
  EXPECT_EQ(last.status, ReadResult::kClosed);
  port.stream->write(bytes);
  EXPECT_FALSE(port.stream->write(bytes)) << "and no signal";
  const OpenedPort none = openPort(path, 115200);
  EXPECT_FALSE(none.stream);
  EXPECT_THAT(none.problem.words(), AllOf(HasSubstr(path + " refuses the connection"), HasSubstr("one program")));
}

TEST(TcpPort, IsClosedToASecondProgram) {
  sim::TcpServer server(0);
  const OpenedPort first = openPort(at(server.port()), 0);
  std::array<std::uint8_t, 16> bytes{};
  server.read(bytes, 2s);
  const OpenedPort second = openPort(at(server.port()), 0);
  ASSERT_TRUE(first.stream && second.stream);
  server.read(bytes, 1ms);
  EXPECT_EQ(second.stream->read(bytes, 2s).status, ReadResult::kClosed);
  EXPECT_EQ(first.stream->read(bytes, 1ms).status, ReadResult::kTimeout);
}

TEST(TcpPort, NamesAnAddressThatIsNone) {
  EXPECT_THAT(openPort("tcp://lidar:2112", 0).problem.words(),
              AllOf(HasSubstr("tcp://lidar:2112 is no address"), HasSubstr("tcp://192.168.0.10:10940")));
}

TEST(TcpPort, NamesAnAddressToWhichNoWayLeads) {
  const OpenedPort port = openPort("tcp://255.255.255.255:2112", 0);
  EXPECT_FALSE(port.stream);
  EXPECT_NE(port.problem.words(), "");
}

}  // namespace
}  // namespace slam::tcp_port_test
