// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/udpm_url.hpp"

#include <gmock/gmock.h>
#include <stdexcept>

namespace slam::udpm_url_test {
namespace {

std::string problemOf(const std::string& url) {
  try {
    parseUdpmUrl(url);
  } catch (const std::invalid_argument& problem) {
    return problem.what();
  }
  return "";
}

TEST(UdpmUrl, IsReadAsLiblcmReadsIt) {
  const UdpmUrl url = parseUdpmUrl("udpm://239.1.2.3:0x1df3?recv_buf_size=4194304&ttl=1");
  EXPECT_EQ(url.name(), "239.1.2.3:7667");
  EXPECT_EQ(url.port(), 7667);
  EXPECT_EQ(url.ttl, 1);
  EXPECT_EQ(url.receive_buffer, 4194304);
  EXPECT_EQ(url.text, "udpm://239.1.2.3:0x1df3?recv_buf_size=4194304&ttl=1");
}

TEST(UdpmUrl, HasDefaults) {
  for (const char* text : {"udpm://", "udpm://?ttl=0", "udpm://239.255.76.67:7667", "udpm://239.255.76.67:7667?"}) {
    const UdpmUrl url = parseUdpmUrl(text);
    EXPECT_EQ(url.name(), "239.255.76.67:7667") << text;
    EXPECT_EQ(url.ttl, 0) << text;
  }
}

TEST(UdpmUrl, RefusesInWordsWhatCannotWork) {
  for (const char* url : {"",
                          "udpm",
                          "udpm:/",
                          " udpm://239.255.76.67:7667",
                          "memq://",
                          "file:///tmp/x.lcm",
                          "tcpq://localhost:7700",
                          "mpudpm://239.255.76.67:7667",
                          "udpm://robot:7667",
                          "udpm://127.0.0.1:7667",
                          "udpm://255.255.255.255:7667",
                          "udpm://239.255.76.67",
                          "udpm://239.255.76.67:",
                          "udpm://239.255.76.67:0",
                          "udpm://239.255.76.67:65536",
                          "udpm://239.255.76.67:7667x",
                          "udpm://239.255.76.67:7667?ttl",
                          "udpm://239.255.76.67:7667?ttl=x",
                          "udpm://239.255.76.67:7667?ttl=-1",
                          "udpm://239.255.76.67:7667?ttl=256",
                          "udpm://239.255.76.67:7667?tll=1"}) {
    EXPECT_THAT(problemOf(url), testing::HasSubstr("use udpm://ADDRESS:PORT?ttl=0")) << url;
  }
  EXPECT_THAT(problemOf("udpm://239.255.76.67:7667?tll=1"), testing::HasSubstr("\"tll\""));
}

}  // namespace
}  // namespace slam::udpm_url_test
