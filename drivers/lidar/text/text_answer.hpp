// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lidar/lidar_unit.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"

namespace slam {

/// Reads text until `find` finds an answer in it.
/// @param find from all that has come to an optional answer, and how much of the text ends with it
/// @param behind out: bytes behind the answer. @return empty when it did not come
template <typename Find>
auto awaitText(rplidar::Dialogue& dialogue, rplidar::Dialogue::Clock now, Duration timeout, const Find& find,
               std::vector<std::uint8_t>& behind) -> decltype(find(std::string_view{}, std::declval<std::size_t&>())) {
  constexpr std::size_t kMostText = 1 << 16;  // [bytes] of old scans that are searched for an answer
  std::string text;
  for (const Timestamp end = now() + timeout; now() < end && !dialogue.hungUp() && !dialogue.cancelled();) {
    const std::vector<std::uint8_t> bytes = dialogue.readOn(end - now());
    text.append(bytes.begin(), bytes.end());
    std::size_t size = 0;
    if (auto answer = find(text, size)) {
      behind.assign(text.begin() + static_cast<std::ptrdiff_t>(size), text.end());
      return answer;
    }
    if (text.size() > kMostText) text.erase(0, text.size() - kMostText / 2);
  }
  return {};
}

/// @return false when it could not be sent
inline bool sendText(ByteStream& port, std::string_view text) {
  return port.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// What a unit that has not answered comes to. @param others who may be there instead, by what came
inline LidarUnit::Begun unanswered(const rplidar::Dialogue& dialogue, WrongDevice& others) {
  if (dialogue.hungUp()) return {DeviceState::kAbsent, problem::kPortGone};
  if (dialogue.cancelled()) return {DeviceState::kAbsent, problem::kStoppedOpening};
  others.recognises(dialogue.recent());
  return {DeviceState::kFault, dialogue.receivedBytes() ? problem::kLidarUndecoded : problem::kLidarUnanswered, true};
}

}  // namespace slam
