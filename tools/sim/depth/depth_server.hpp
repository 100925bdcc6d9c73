// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <vector>

#include "tools/sim/depth/depth_faults.hpp"
#include "tools/sim/depth/depth_stream.hpp"

namespace slam::sim {

/// Serves the camera on a stream socket, to one client at a time, as depth_wire.hpp says. For one thread.
class DepthServer {
 public:
  /// Takes the place of a socket that an earlier server left behind.
  /// @throws std::system_error when the socket cannot be made
  DepthServer(const std::filesystem::path& path, const World& world, std::uint64_t seed,
              DepthStream::Viewpoint viewpoint);
  ~DepthServer();
  DepthServer(const DepthServer&) = delete;
  DepthServer& operator=(const DepthServer&) = delete;

  /// @return false for a fault that DepthFaults does not know
  bool inject(std::string_view kind, double value);
  /// Does what there is to do, or waits for it; returns after `limit` or earlier.
  void serve(Duration limit);

 private:
  void listen();
  void unplug();
  void accept(Duration limit);
  void readRequest(Duration limit);
  void stream(Duration limit);
  void takeFrame(Timestamp now);
  void send();
  void dropClient();

  std::filesystem::path path_;
  World world_;  // a copy, so that rendering needs no lock
  std::uint64_t seed_;
  DepthStream::Viewpoint viewpoint_;
  int listener_ = -1, client_ = -1;
  Timestamp accepted_{};
  std::optional<DepthStream> stream_;
  DepthFaults faults_;
  struct Delayed {
    Timestamp due;
    std::vector<std::uint8_t> bytes;
  };
  std::deque<Delayed> delayed_;
  std::vector<std::uint8_t> out_;  // frame on its way
  std::size_t sent_ = 0;           // [bytes] of it
};

}  // namespace slam::sim
