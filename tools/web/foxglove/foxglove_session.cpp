// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/foxglove_session.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "tools/slamctl/health_json.hpp"

namespace slam {
namespace {

using nlohmann::json;

constexpr int kWarning = 1, kError = 2;  // levels of a status

std::string statusText(int level, const std::string& words) {
  return textOf({{"op", "status"}, {"level", level}, {"message", words}});
}

std::optional<std::uint32_t> numberOf(const json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto number = value.get<std::uint64_t>();
  if (number > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(number);
}

std::optional<std::uint32_t> numberAt(const json& object, const char* key) {
  const auto at = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && at != object.end() ? numberOf(*at) : std::nullopt;
}

/// @return nullptr where there is no such list
const json* listAt(const json& object, const char* key) {
  const auto at = object.find(key);
  return at != object.end() && at->is_array() ? &*at : nullptr;
}

}  // namespace

FoxgloveSession::Reply FoxgloveSession::take(std::string_view text) {
  Reply reply;
  const json message = json::parse(text, nullptr, false);
  const auto op = message.is_object() ? message.find("op") : message.end();
  const bool has_op = message.is_object() && op != message.end() && op->is_string();
  const std::string name = has_op ? op->get<std::string>() : "";
  std::string fault;
  int level = kWarning;
  if (!has_op) {
    fault = "not a JSON object with a text \"op\"";
    level = kError;
  } else if (name == "subscribe") {
    fault = subscribe(message, reply);
  } else if (name == "unsubscribe") {
    fault = unsubscribe(message);
  } else {
    fault = "known ops are subscribe and unsubscribe; nothing can be published here";
  }
  if (fault.empty()) return reply;
  reply.text = statusText(level, fault);
  reply.ends = ++faults_ > kMostFaults;
  return reply;
}

std::string FoxgloveSession::subscribe(const json& message, Reply& reply) {
  const json* list = listAt(message, "subscriptions");
  if (list == nullptr) return "\"subscriptions\" is no list";
  std::string fault;
  for (const json& entry : *list) {
    const auto id = numberAt(entry, "id"), channel = numberAt(entry, "channelId");
    if (!id || !channel) {
      fault = "a subscription needs \"id\" and \"channelId\", whole numbers of 32 bits";
    } else if (*channel >= kFoxgloveTopics) {
      fault = "there is no channel " + std::to_string(*channel);
    } else if (subscriptions_[*channel]) {
      fault = "channel " + std::to_string(*channel) + " is subscribed to already";
    } else if (std::find(subscriptions_.begin(), subscriptions_.end(), id) != subscriptions_.end()) {
      fault = "subscription " + std::to_string(*id) + " exists already";
    } else {
      subscriptions_[*channel] = id;
      reply.begun.set(*channel);
    }
  }
  return fault;
}

std::string FoxgloveSession::unsubscribe(const json& message) {
  const json* list = listAt(message, "subscriptionIds");
  if (list == nullptr) return "\"subscriptionIds\" is no list";
  std::string fault;
  for (const json& entry : *list) {
    const auto id = numberOf(entry);
    const auto at = id ? std::find(subscriptions_.begin(), subscriptions_.end(), id) : subscriptions_.end();
    if (at == subscriptions_.end()) {
      fault = "there is no such subscription";
    } else {
      at->reset();
    }
  }
  return fault;
}

std::string foxgloveServerInfo(std::string_view name, std::string_view session) {
  return json{{"op", "serverInfo"}, {"name", name}, {"capabilities", json::array()}, {"sessionId", session}}.dump();
}

std::string foxgloveAdvertisement() {
  json channels = json::array();
  for (const FoxgloveChannel& channel : foxgloveChannels())
    channels.push_back({{"id", channels.size()},
                        {"topic", channel.topic},
                        {"encoding", "json"},
                        {"schemaName", channel.schema_name},
                        {"schema", channel.schema},
                        {"schemaEncoding", "jsonschema"}});
  return json{{"op", "advertise"}, {"channels", std::move(channels)}}.dump();
}

std::string foxgloveMessageHead(std::uint32_t subscription, std::int64_t received) {
  constexpr char kMessageData = 1;
  constexpr std::uint64_t kNanoseconds = 1000;  // of a microsecond
  std::string head(1, kMessageData);
  for (int i = 0; i < 4; ++i) head.push_back(static_cast<char>(subscription >> (8 * i) & 0xFF));
  const std::uint64_t time = static_cast<std::uint64_t>(received) * kNanoseconds;
  for (int i = 0; i < 8; ++i) head.push_back(static_cast<char>(time >> (8 * i) & 0xFF));
  return head;
}

}  // namespace slam
