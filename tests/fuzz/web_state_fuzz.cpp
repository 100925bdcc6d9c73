// SPDX-License-Identifier: BSD-3-Clause
// The input is what anybody on the network sends as slamd: for each message a byte that chooses its channel, two bytes
// of its length, and the message without its fingerprint. 0.1 s pass with each.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bus/checked_decode.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/web/text/event_text.hpp"
#include "tools/web/web_state.hpp"

namespace slam {
namespace {

class Page {
 public:
  void check(fuzz::Input input) {
    state_.begin(now_);
    while (!input.atEnd()) {
      now_ += std::chrono::milliseconds(100);
      const auto channel = input.take<std::uint8_t>();
      take(channel, input.takeBytes(input.take<std::uint16_t>()));
      const std::string news = feed_.news(state_, now_);
      FUZZ_CHECK(news.empty() || news.ends_with("\n\n"));
      FUZZ_CHECK(state_.trail().size() <= DrivenPath::kLongestTrail);
      FUZZ_CHECK(state_.closures().size() <= WebState::kMostClosures);
      FUZZ_CHECK(state_.scan().size() <= WebState::kMostPoints && state_.depth().size() <= WebState::kMostPoints);
      FUZZ_CHECK(state_.tiles().size() <= TileStore::kMostTiles && state_.tiles().bytes() <= TileStore::kMostBytes);
    }
    FUZZ_CHECK(feed_.greeting(state_, now_).ends_with("\n\n"));
    if (const auto image = state_.tiles().image()) {
      FUZZ_CHECK(static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height) <=
                 TileStore::kMostCells);
    }
  }

 private:
  void take(std::uint8_t channel, fuzz::Bytes body) {
    switch (channel % 10) {
      case 0:
        return takeAs<pose_estimate_t>(body);
      case 1:
        return takeAs<health_t>(body);
      case 2:
        return takeAs<scan_t>(body);
      case 3:
        return takeAs<depth_t>(body);
      case 4:
        return takeAs<map_meta_t>(body);
      case 8:
        return takeAs<problems_t>(body);
      case 9:
        return takeAs<map_edit_t>(body);
      default:
        if (const auto tile = decode<map_tile_t>(body))
          state_.take(static_cast<MapLayer>(channel % 10 - 5), *tile, now_);
    }
  }
  template <typename Message>
  void takeAs(fuzz::Bytes body) {
    if (const auto message = decode<Message>(body)) state_.take(*message, now_);
  }
  template <typename Message>
  static std::optional<Message> decode(fuzz::Bytes body) {
    std::vector<std::uint8_t> datagram;
    const auto fingerprint = static_cast<std::uint64_t>(Message::getHash());
    for (int shift = 56; shift >= 0; shift -= 8) datagram.push_back(static_cast<std::uint8_t>(fingerprint >> shift));
    datagram.insert(datagram.end(), body.begin(), body.end());
    return decodeChecked<Message>(datagram);
  }

  Timestamp now_{std::chrono::seconds(1000)};
  WebState state_{Config{}};
  EventFeed feed_{1, true, "0"};
};

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slam::Page().check(slam::fuzz::Input({data, size}));
  return 0;
}
