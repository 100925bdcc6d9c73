// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/byte_stream.hpp"

#include <array>
#include <ctime>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "drivers/pseudo_terminal.hpp"
#include "support/modem_lines.hpp"

namespace slam::byte_stream_test {
namespace {

using std::chrono::milliseconds;
using test::Bytes;
using test::PseudoTerminal;

constexpr Duration kLong = std::chrono::seconds(20);

Duration cpuTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Reads until `size` bytes are there.
Bytes readAll(ByteStream& stream, std::size_t size) {
  Bytes all;
  std::array<std::uint8_t, 64> buffer{};
  while (all.size() < size) {
    const ReadResult result = stream.read(buffer, kLong);
    if (result.status != ReadResult::kData) break;
    all.insert(all.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(result.size));
  }
  return all;
}

Bytes everyByte() {
  Bytes bytes(256);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  return bytes;
}

class SocketStream : public testing::Test {
 protected:
  SocketStream() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::runtime_error("no socket pair");
    peer_ = ends[0];
    stream_ = makeDescriptorStream(ends[1]);
  }
  ~SocketStream() override { hangUp(); }
  void hangUp() {
    if (peer_ >= 0) close(peer_);
    peer_ = -1;
  }
  void peerWrites(const Bytes& bytes) {
    ASSERT_EQ(::write(peer_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }

  int peer_ = -1;
  std::unique_ptr<ByteStream> stream_;
  std::array<std::uint8_t, 16> buffer_{};
};

TEST_F(SocketStream, GivesWhatIsThereWithoutWaitingForMore) {
  peerWrites({1, 2, 3});
  const ReadResult result = stream_->read(buffer_, kLong);
  EXPECT_EQ(result.status, ReadResult::kData);
  ASSERT_EQ(result.size, 3U);
  EXPECT_THAT(std::span(buffer_).first(3), testing::ElementsAre(1, 2, 3));
}

TEST_F(SocketStream, TakesNoMoreThanTheBufferHolds) {
  const Bytes sent = everyByte();
  peerWrites(sent);
  EXPECT_EQ(stream_->read(buffer_, kLong).size, buffer_.size());
  EXPECT_EQ(readAll(*stream_, 240), Bytes(sent.begin() + 16, sent.end()));
}

TEST_F(SocketStream, TimesOutAfterWaitingWithoutSpinning) {
  const Timestamp begin = monotonicNow();
  const Duration cpu = cpuTime();
  const ReadResult result = stream_->read(buffer_, milliseconds(200));
  EXPECT_EQ(result.status, ReadResult::kTimeout);
  EXPECT_EQ(result.size, 0U);
  EXPECT_GE(monotonicNow() - begin, milliseconds(195));
  EXPECT_LT(cpuTime() - cpu, milliseconds(50));
}

TEST_F(SocketStream, RestsAlthoughBytesCame) {
  peerWrites({1});
  const Timestamp begin = monotonicNow();
  stream_->rest(milliseconds(20));
  EXPECT_GE(monotonicNow() - begin, milliseconds(20));
  EXPECT_EQ(readAll(*stream_, 1), Bytes{1});
}

TEST_F(SocketStream, WakesWhenBytesComeFromAnotherThread) {
  std::thread other([&] { peerWrites({7}); });
  EXPECT_EQ(stream_->read(buffer_, kLong).status, ReadResult::kData);
  other.join();
  EXPECT_EQ(buffer_[0], 7);
}

TEST_F(SocketStream, GivesTheLastBytesThenReportsTheHangUp) {
  peerWrites({1, 2, 3});
  hangUp();
  const Timestamp begin = monotonicNow();
  EXPECT_EQ(readAll(*stream_, 4), (Bytes{1, 2, 3}));
  EXPECT_EQ(stream_->read(buffer_, kLong).status, ReadResult::kClosed);
  EXPECT_LT(monotonicNow() - begin, kLong / 2) << "does not wait for the time-out";
}

TEST_F(SocketStream, WritesEverythingOrReportsThatItDidNot) {
  EXPECT_TRUE(stream_->write(everyByte()));
  Bytes received(256);
  ASSERT_EQ(::read(peer_, received.data(), received.size()), 256);
  EXPECT_EQ(received, everyByte());
  EXPECT_FALSE(stream_->write(Bytes(64 << 20))) << "nobody reads: the line cannot take it all";
}

TEST_F(SocketStream, DiscardsItsInput) {
  peerWrites({1, 2, 3});
  stream_->discardInput();
  EXPECT_EQ(stream_->read(buffer_, milliseconds(20)).status, ReadResult::kTimeout);
  peerWrites({4});
  EXPECT_EQ(readAll(*stream_, 1), Bytes{4});
}

/// With modem lines, as a serial port has them, and without, as a pseudo-terminal.
class OpenedTerminal : public testing::TestWithParam<bool> {
 protected:
  OpenedTerminal() { test::has_modem_lines = GetParam(); }
  ~OpenedTerminal() override { test::has_modem_lines = false; }
};
INSTANTIATE_TEST_SUITE_P(Lines, OpenedTerminal, testing::Bool());

TEST_P(OpenedTerminal, CarriesEveryByteUnchangedBothWays) {
  PseudoTerminal device;
  const OpenedPort port = openPort(device.path(), 115200);
  ASSERT_TRUE(port.stream) << port.problem.words();
  EXPECT_FALSE(port.problem);
  device.write(everyByte());
  EXPECT_EQ(readAll(*port.stream, 256), everyByte());
  ASSERT_TRUE(port.stream->write(everyByte()));
  Bytes received;
  while (received.size() < 256) {
    const Bytes part = device.read(kLong);
    ASSERT_FALSE(part.empty());
    received.insert(received.end(), part.begin(), part.end());
  }
  EXPECT_EQ(received, everyByte());
}

TEST_P(OpenedTerminal, SetsDtrWhereThereIsOne) {
  PseudoTerminal device;
  const OpenedPort port = openPort(device.path(), 115200);
  ASSERT_TRUE(port.stream) << port.problem.words();
  EXPECT_EQ(port.stream->setDtr(true), GetParam());
}

TEST_P(OpenedTerminal, DiscardsItsInput) {
  PseudoTerminal device;
  const OpenedPort port = openPort(device.path(), 115200);
  ASSERT_TRUE(port.stream) << port.problem.words();
  device.write(Bytes{1, 2, 3});
  std::array<std::uint8_t, 1> first{};
  ASSERT_EQ(port.stream->read(first, kLong).status, ReadResult::kData);  // the rest has arrived as well
  port.stream->discardInput();
  EXPECT_EQ(port.stream->read(first, milliseconds(20)).status, ReadResult::kTimeout);
}

TEST_P(OpenedTerminal, ReportsAHangUpAtOnce) {
  PseudoTerminal device;
  const OpenedPort port = openPort(device.path(), 115200);
  ASSERT_TRUE(port.stream) << port.problem.words();
  std::thread other([&] { device.unplug(); });
  std::array<std::uint8_t, 16> buffer{};
  const Timestamp begin = monotonicNow();
  EXPECT_EQ(port.stream->read(buffer, kLong).status, ReadResult::kClosed);
  EXPECT_LT(monotonicNow() - begin, kLong / 2);
  other.join();
  EXPECT_FALSE(port.stream->write(Bytes{1}));
}

TEST_P(OpenedTerminal, IsLockedAgainstOthers) {
  PseudoTerminal device;
  const OpenedPort first = openPort(device.path(), 115200);
  ASSERT_TRUE(first.stream) << first.problem.words();
  const OpenedPort second = openPort(device.path(), 115200);
  EXPECT_FALSE(second.stream);
  EXPECT_TRUE(second.problem);
}

TEST_P(OpenedTerminal, CanBeOpenedAgainAfterItWasClosed) {
  PseudoTerminal device;
  EXPECT_TRUE(openPort(device.path(), 115200).stream);
  const OpenedPort again = openPort(device.path(), 921600);
  EXPECT_TRUE(again.stream) << again.problem.words();
}

TEST(OpenPort, ReportsWhyItCannot) {
  for (const char* path : {"/dev/no_such_port", "/no/such/folder/port", ""}) {
    const OpenedPort port = openPort(path, 115200);
    EXPECT_FALSE(port.stream) << path;
    EXPECT_TRUE(port.problem) << path;
  }
}

TEST(OpenPort, RefusesAPlainFile) {
  const std::string path = std::filesystem::temp_directory_path() / ("slamd_plain_" + std::to_string(getpid()));
  close(open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600));
  const OpenedPort port = openPort(path, 115200);
  EXPECT_FALSE(port.stream);
  EXPECT_TRUE(port.problem);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace slam::byte_stream_test
