// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Frames of a WebSocket's client (RFC 6455, section 5.2), written apart from the library that is tested.
namespace slam::test {

enum : std::uint8_t { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

struct Frame {
  int opcode;
  bool is_last;
  std::string payload;
};

inline std::string clientFrame(std::uint8_t opcode, std::string_view payload, bool is_last = true) {
  constexpr char kMask[] = {0x12, 0x34, 0x56, 0x78};
  std::string frame(1, static_cast<char>(opcode | (is_last ? 0x80 : 0)));
  if (payload.size() < 126) {
    frame += static_cast<char>(0x80 | payload.size());
  } else {
    frame += static_cast<char>(0x80 | 126);
    frame += static_cast<char>(payload.size() >> 8);
    frame += static_cast<char>(payload.size() & 0xFF);
  }
  frame.append(kMask, sizeof kMask);
  for (std::size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ kMask[i % 4]);
  return frame;
}

/// The whole frames in what a server sends.
inline std::vector<Frame> framesOf(std::string_view bytes) {
  std::vector<Frame> frames;
  const auto byteAt = [&](std::size_t i) { return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i])); };
  while (bytes.size() >= 2) {
    std::uint64_t size = byteAt(1) & 0x7F;
    const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
    if (bytes.size() < 2 + more) break;
    if (more > 0) size = 0;
    for (std::size_t i = 0; i < more; ++i) size = size << 8 | byteAt(2 + i);
    if (bytes.size() < 2 + more + size) break;
    frames.push_back(
        {static_cast<int>(byteAt(0) & 0xF), (byteAt(0) & 0x80) != 0, std::string(bytes.substr(2 + more, size))});
    bytes.remove_prefix(2 + more + size);
  }
  return frames;
}

/// Frames of data joined to messages.
inline std::vector<Frame> messagesOf(const std::vector<Frame>& frames) {
  std::vector<Frame> messages;
  for (const Frame& frame : frames) {
    if (frame.opcode >= kClose) continue;
    frame.opcode == kContinuation ? messages.back().payload += frame.payload
                                  : (messages.push_back(frame), std::string());
  }
  return messages;
}

}  // namespace slam::test
