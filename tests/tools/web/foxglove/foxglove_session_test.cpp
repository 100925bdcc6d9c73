// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/foxglove_session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace slam::foxglove_session_test {
namespace {

using nlohmann::json;

TEST(FoxgloveSession, SubscribesAndUnsubscribes) {
  FoxgloveSession session;
  const auto reply =
      session.take(R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":0},{"id":4294967295,"channelId":6}]})");
  EXPECT_EQ(reply.text, "");
  EXPECT_TRUE(reply.begun[0] && reply.begun[6]);
  EXPECT_EQ(reply.begun.count(), 2U);
  EXPECT_EQ(session.subscriptionTo(FoxgloveTopic::kScan), 7U);
  EXPECT_EQ(session.subscriptionTo(FoxgloveTopic::kMap), 4294967295U);
  EXPECT_FALSE(session.isWanted(FoxgloveTopic::kPose));
  EXPECT_EQ(session.take(R"({"op":"unsubscribe","subscriptionIds":[7]})").text, "");
  EXPECT_FALSE(session.isWanted(FoxgloveTopic::kScan));
  EXPECT_TRUE(session.isWanted(FoxgloveTopic::kMap));
}

TEST(FoxgloveSession, AnswersWhatIsWrongWithAStatus) {
  for (const char* text :
       {"", "{", "[]", "null", R"("op")", R"({"op":3})", R"({"op":"advertise","channels":[]})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":{}})", R"({"op":"subscribe","subscriptions":[3]})",
        R"({"op":"subscribe","subscriptions":[{"id":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":99}]})",
        R"({"op":"unsubscribe","subscriptionIds":[5]})", R"({"op":"unsubscribe","subscriptionIds":["5"]})"}) {
    FoxgloveSession session;
    const auto reply = session.take(text);
    ASSERT_FALSE(reply.text.empty()) << text;
    const json status = json::parse(reply.text);
    EXPECT_EQ(status["op"], "status");
    EXPECT_GE(status["level"], 1);
    EXPECT_TRUE(reply.begun.none());
    EXPECT_FALSE(reply.ends);
  }
}

TEST(FoxgloveSession, KeepsTheFirstOfTwoSubscriptions) {
  FoxgloveSession session;
  session.take(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":0}]})");
  EXPECT_NE(session.take(R"({"op":"subscribe","subscriptions":[{"id":2,"channelId":0}]})").text, "");
  EXPECT_NE(session.take(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":1}]})").text, "");
  EXPECT_EQ(session.subscriptionTo(FoxgloveTopic::kScan), 1U);
  EXPECT_FALSE(session.isWanted(FoxgloveTopic::kDepth));
}

TEST(FoxgloveSession, EndsAfterManyFaults) {
  FoxgloveSession session;
  for (int i = 0; i < FoxgloveSession::kMostFaults; ++i) EXPECT_FALSE(session.take("?").ends);
  EXPECT_TRUE(session.take("?").ends);
}

TEST(FoxgloveSession, GreetsAsTheSpecificationAsksFor) {
  const json info = json::parse(foxgloveServerInfo("slamd", "12"));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["capabilities"], json::array());
  EXPECT_EQ(info["sessionId"], "12");
  const json advertise = json::parse(foxgloveAdvertisement());
  EXPECT_EQ(advertise["op"], "advertise");
  ASSERT_EQ(advertise["channels"].size(), kFoxgloveTopics);
  const json& map = advertise["channels"][static_cast<std::size_t>(FoxgloveTopic::kMap)];
  EXPECT_EQ(map["id"], static_cast<int>(FoxgloveTopic::kMap));
  EXPECT_EQ(map["topic"], "/map");
  EXPECT_EQ(map["encoding"], "json");
  EXPECT_EQ(map["schemaName"], "foxglove.Grid");
  EXPECT_EQ(map["schemaEncoding"], "jsonschema");
  EXPECT_EQ(json::parse(map["schema"].get<std::string>())["properties"]["data"]["type"], "string");
}

TEST(FoxgloveSession, PutsSubscriptionAndTimeBeforeAMessage) {
  EXPECT_EQ(foxgloveMessageHead(0x01020304, 1), std::string("\x01\x04\x03\x02\x01\xE8\x03\0\0\0\0\0\0", 13));
}

}  // namespace
}  // namespace slam::foxglove_session_test
