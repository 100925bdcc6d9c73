// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/upgrade.hpp"

#include <gtest/gtest.h>

namespace slam::upgrade_test {
namespace {

httplib::Request handshake() {
  httplib::Request request;
  request.method = "GET";
  request.headers = {{"Upgrade", "websocket"},
                     {"Connection", "keep-alive, Upgrade"},
                     {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="},
                     {"Sec-WebSocket-Version", "13"},
                     {"Sec-WebSocket-Protocol", "other, foxglove.websocket.v1"}};
  return request;
}

/// @return 101, or the status of the refusal
int statusOf(const httplib::Request& request) {
  httplib::Response response;
  const bool done = upgrade(request, response, [](const std::string& host) { return host == "robot"; });
  EXPECT_EQ(done, response.status == 101);
  return response.status;
}

httplib::Request with(const char* header, const char* value) {
  httplib::Request request = handshake();
  request.headers.erase(header);
  if (value != nullptr) request.headers.emplace(header, value);
  return request;
}

TEST(Upgrade, AnswersWithTheKeyOfTheSpecification) {  // RFC 6455, section 1.3
  httplib::Response response;
  ASSERT_TRUE(upgrade(handshake(), response, [](const std::string&) { return false; }));
  EXPECT_EQ(response.get_header_value("Sec-WebSocket-Accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_EQ(response.get_header_value("Sec-WebSocket-Protocol"), "foxglove.websocket.v1");
  response.set_header("Connection", "close");
  response.set_header("Content-Length", "0");
  finishUpgrade(response);
  EXPECT_EQ(response.get_header_value("Connection"), "Upgrade");
  EXPECT_FALSE(response.has_header("Content-Length"));
}

TEST(Upgrade, RefusesWhatIsNoHandshake) {
  EXPECT_EQ(statusOf(with("Upgrade", "h2c")), 426);
  EXPECT_FALSE(isUpgrade(with("Upgrade", "h2c"))) << "an offer of HTTP/2, which may be passed over";
  EXPECT_TRUE(isUpgrade(with("Upgrade", "WebSocket")));
  EXPECT_EQ(statusOf(with("Connection", "close")), 426);
  EXPECT_EQ(statusOf(with("Sec-WebSocket-Key", "short")), 426);
  EXPECT_EQ(statusOf(with("Sec-WebSocket-Key", nullptr)), 426);
  EXPECT_EQ(statusOf(with("Sec-WebSocket-Version", "8")), 426);
  EXPECT_EQ(statusOf(with("Sec-WebSocket-Protocol", "other")), 400);
  EXPECT_EQ(statusOf(with("Sec-WebSocket-Protocol", nullptr)), 400);
}

TEST(Upgrade, IsForPagesOfOwnNamesAndOfFoxglove) {
  for (const char* origin : {"http://robot:8080", "https://app.foxglove.dev", "file://", "app://foxglove"})
    EXPECT_EQ(statusOf(with("Origin", origin)), 101) << origin;
  for (const char* origin :
       {"https://stranger.example", "null", "https://app.foxglove.dev.stranger.example", "http://"})
    EXPECT_EQ(statusOf(with("Origin", origin)), 403) << origin;
}

}  // namespace
}  // namespace slam::upgrade_test
