// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <bitset>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/foxglove/foxglove_feed.hpp"
#include "tools/web/web_pages.hpp"

namespace slam {

struct FoxgloveLimits {
  std::size_t most = 16;                          ///< clients; then the oldest one of the address that has most goes
  std::size_t most_unsent = 4 << 20;              ///< [bytes] that wait for one; one message alone may be longer
  std::int64_t most_cells = 4 << 20;              ///< of a picture of the map; a larger one is sent coarser
  Duration patience = std::chrono::seconds(10);   ///< with one who takes nothing
  Duration map_period = std::chrono::seconds(2);  ///< between pictures of a map that changes
};

/// The clients of Foxglove's protocol, in a thread of its own. A message is written only where somebody has subscribed
/// to it, and once for all. Who reads too slowly gets the newest: the oldest waiting messages make place. Memory is
/// bounded.
class FoxgloveHub {
 public:
  /// @param shared the state that the map comes from, and where clients are counted @param session another one for each
  /// start of the program
  FoxgloveHub(SharedState& shared, const Config& config, std::string session, const FoxgloveLimits& limits = {});
  ~FoxgloveHub();
  FoxgloveHub(const FoxgloveHub&) = delete;
  FoxgloveHub& operator=(const FoxgloveHub&) = delete;

  /// Owns the socket from now on; the handshake is done. @param received what came behind it
  void add(int socket, std::string address, std::string_view received);
  /// A message of slamd, from any thread.
  template <typename Message>
  void take(const Message& message) {
    if (wanted_ == 0) return;
    const std::lock_guard lock(mutex_);
    feed_.take(message);
  }
  /// Whether anybody has subscribed to anything.
  bool isWatched() const { return wanted_ != 0; }

 private:
  struct Client;
  void run();
  std::vector<int> wait();
  void tend(const std::vector<int>& readable, Timestamp now);
  bool serve(Client& client, bool readable, Timestamp now);
  void answer(Client& client, std::string_view text);
  void makePlace();
  void send(FoxgloveTopic topic, const std::shared_ptr<const std::string>& body);
  void drawMap();
  void wake() const;

  SharedState& shared_;
  const FoxgloveLimits limits_;
  const std::string session_;
  const int wake_;
  mutable std::mutex mutex_;                      // of clients and feed
  std::vector<std::unique_ptr<Client>> clients_;  // the oldest first
  FoxgloveFeed feed_;
  std::atomic<std::uint32_t> wanted_{0};  // a bit for each topic
  struct {
    std::atomic<bool> asked{false};  // by one who has subscribed
    std::optional<std::uint64_t> version;
    Timestamp due{};
  } map_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace slam
