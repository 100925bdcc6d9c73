// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/web_socket.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/web/foxglove/client_frames.hpp"

namespace slam::web_socket_test {
namespace {

using test::clientFrame;
using test::framesOf;
using test::kBinary;
using test::kClose;
using test::kContinuation;
using test::kPing;
using test::kPong;
using test::kText;
using testing::ElementsAre;

class WebSocketTest : public testing::Test {
 protected:
  void build(const WebSocket::Limits& limits) {
    socket_ = std::make_unique<WebSocket>(limits, [this](std::string_view text) { texts_.emplace_back(text); });
  }
  WebSocketTest() { build({}); }
  /// All that it sends.
  std::vector<test::Frame> sent() {
    std::string bytes;
    for (std::string_view part; !(part = socket_->output()).empty(); socket_->written(part.size())) bytes += part;
    return framesOf(bytes);
  }
  /// The status of the closing frame, which is the last one.
  int closingStatus() {
    const auto frames = sent();
    if (frames.empty() || frames.back().opcode != kClose || frames.back().payload.size() < 2) return 0;
    return static_cast<unsigned char>(frames.back().payload[0]) << 8 |
           static_cast<unsigned char>(frames.back().payload[1]);
  }

  std::vector<std::string> texts_;
  std::unique_ptr<WebSocket> socket_;
};

TEST_F(WebSocketTest, TakesTextThatComesByteForByteAndInFragments) {
  const std::string bytes = clientFrame(kText, "one") + clientFrame(kText, "tw", false) + clientFrame(kPing, "p") +
                            clientFrame(kContinuation, "o");
  for (const char byte : bytes) socket_->receive({&byte, 1});
  EXPECT_THAT(texts_, ElementsAre("one", "two"));
  const auto frames = sent();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].opcode, kPong);
  EXPECT_EQ(frames[0].payload, "p");
  EXPECT_FALSE(socket_->isOver());
}

TEST_F(WebSocketTest, SendsLongMessagesWhole) {
  const auto body = std::make_shared<const std::string>(300'000, 'b');
  EXPECT_EQ(socket_->send({"head", body, true}), 0U);
  EXPECT_EQ(socket_->send({"{}", nullptr, false}), 0U);
  const auto messages = test::messagesOf(sent());
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].opcode, kBinary);
  EXPECT_EQ(messages[0].payload, "head" + *body);
  EXPECT_EQ(messages[1].opcode, kText);
  EXPECT_EQ(messages[1].payload, "{}");
}

TEST_F(WebSocketTest, DropsTheOldestOfWhoDoesNotRead) {
  build({.most_unsent = 1000, .out_buffer = 10});
  std::size_t dropped = 0;
  for (char name = 'a'; name <= 'j'; ++name) dropped += socket_->send({std::string(300, name), nullptr, false});
  EXPECT_EQ(dropped, 7U);
  const auto messages = test::messagesOf(sent());
  ASSERT_EQ(messages.size(), 3U);
  EXPECT_EQ(messages[0].payload[0], 'h');
  EXPECT_EQ(messages[2].payload[0], 'j');
}

TEST_F(WebSocketTest, SendsOneMessageThatIsLongerThanTheQueue) {
  build({.most_unsent = 1000});
  EXPECT_EQ(socket_->send({std::string(100, 'a'), nullptr, false}), 0U);
  EXPECT_EQ(socket_->send({std::string(5000, 'b'), nullptr, false}), 1U);
  EXPECT_EQ(test::messagesOf(sent()).at(0).payload.size(), 5000U);
}

TEST_F(WebSocketTest, ClosesWhoDoesNotMask) {
  socket_->receive(std::string("\x81\x03one", 5));
  EXPECT_TRUE(texts_.empty());
  EXPECT_EQ(closingStatus(), 1002);
  EXPECT_TRUE(socket_->isOver());
}

TEST_F(WebSocketTest, ClosesWhoSendsTooMuch) {
  build({.longest = 100});
  socket_->receive(clientFrame(kText, std::string(100, 'a')));
  EXPECT_EQ(texts_.size(), 1U);
  socket_->receive(clientFrame(kText, std::string(101, 'a')).substr(0, 10));
  EXPECT_EQ(closingStatus(), 1009);
  EXPECT_TRUE(socket_->isOver());
}

TEST_F(WebSocketTest, ClosesWhoSendsTooMuchInFragments) {
  build({.longest = 100});
  socket_->receive(clientFrame(kText, std::string(60, 'a'), false));
  socket_->receive(clientFrame(kContinuation, std::string(60, 'a'), false));
  EXPECT_EQ(closingStatus(), 1009);
}

TEST_F(WebSocketTest, ClosesForBinaryAndForTextThatIsNone) {
  socket_->receive(clientFrame(kBinary, "x"));
  EXPECT_EQ(closingStatus(), 1003);
  build({});
  socket_->receive(clientFrame(kText, "\xFF\xFE"));
  EXPECT_EQ(closingStatus(), 1007);
  EXPECT_TRUE(texts_.empty());
}

TEST_F(WebSocketTest, EndsWithWhoPingsAndDoesNotRead) {
  for (int i = 0; i < 1000 && !socket_->isOver(); ++i) socket_->receive(clientFrame(kPing, "p"));
  EXPECT_TRUE(socket_->isOver());
}

TEST_F(WebSocketTest, AnswersTheEnd) {
  socket_->receive(clientFrame(kClose, std::string("\x03\xE8", 2)));
  EXPECT_EQ(closingStatus(), 1000);
  EXPECT_TRUE(socket_->isOver());
  EXPECT_EQ(socket_->send({"late", nullptr, false}), 0U);
  EXPECT_TRUE(socket_->output().empty());
}

}  // namespace
}  // namespace slam::web_socket_test
