// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "tools/sim/depth/depth_wire.hpp"

namespace slam::sim {

/// Is someone listening on the socket?
bool isServed(const std::string& path);

/// The client's side of the simulated camera's socket. read() belongs to one thread; interrupt() may be called by any.
class FrameSource {
 public:
  FrameSource() = default;
  ~FrameSource() { close(); }
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// Connects and asks for a mode. @return false when nobody takes it
  bool open(const std::string& path, const DepthMode& mode);
  /// Waits for a whole frame. @return false when the stream is over: interrupted, hung up or malformed
  bool read(DepthFrameHeader& header, std::vector<std::uint16_t>& pixels);
  /// Lets a waiting read() return false, and all later ones.
  void interrupt();
  void close();

 private:
  bool receive(void* data, std::size_t size);

  int descriptor_ = -1;
  DepthMode mode_{};
};

}  // namespace slam::sim
