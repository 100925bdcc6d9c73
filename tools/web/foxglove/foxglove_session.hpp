// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <bitset>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tools/foxglove/foxglove_feed.hpp"

namespace slam {

/// What one client of Foxglove's protocol (github.com/foxglove/ws-protocol, docs/spec.md) has subscribed to. Channel n
/// is topic n. Pure; whatever a client sends, its memory is that of the channels.
class FoxgloveSession {
 public:
  static constexpr int kMostFaults = 16;  ///< messages that are wrong; one more ends the connection

  struct Reply {
    std::bitset<kFoxgloveTopics> begun;  ///< topics that are subscribed to since this message
    std::string text;                    ///< to send back; empty: nothing
    bool ends = false;
  };
  /// @param text a message of the client
  Reply take(std::string_view text);

  /// Number of the client's subscription to a topic, which goes in front of its messages.
  std::optional<std::uint32_t> subscriptionTo(FoxgloveTopic topic) const {
    return subscriptions_[static_cast<std::size_t>(topic)];
  }
  bool isWanted(FoxgloveTopic topic) const { return subscriptionTo(topic).has_value(); }

 private:
  std::string subscribe(const nlohmann::json& message, Reply& reply);
  std::string unsubscribe(const nlohmann::json& message);

  std::array<std::optional<std::uint32_t>, kFoxgloveTopics> subscriptions_;
  int faults_ = 0;
};

/// The two messages that a client gets first. @param session another one for each start of the program
std::string foxgloveServerInfo(std::string_view name, std::string_view session);
std::string foxgloveAdvertisement();
/// What stands in front of each message. @param received [us since the epoch]
std::string foxgloveMessageHead(std::uint32_t subscription, std::int64_t received);

}  // namespace slam
