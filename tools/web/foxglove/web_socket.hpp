// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

struct wslay_event_context;

namespace slam {

/// The server's side of a WebSocket (RFC 6455) behind its handshake: bytes in, bytes out, framed and checked by
/// libwslay. Who breaks the protocol gets its closing frame, and then isOver(). Pure: no socket. Memory is bounded by
/// the limits.
class WebSocket {
 public:
  struct Limits {
    std::size_t longest = 16 * 1024;     ///< [bytes] of a message that comes
    std::size_t most_unsent = 4 << 20;   ///< [bytes] of messages that wait; one alone may be longer
    std::size_t most_answers = 64;       ///< pongs that wait, for one who pings and does not read
    std::size_t out_buffer = 64 * 1024;  ///< [bytes] framed
  };
  /// What is sent: binary messages have a head of their own and a body that others share.
  struct Message {
    std::string head;
    std::shared_ptr<const std::string> body;
    bool binary = true;
    std::size_t size() const { return head.size() + (body ? body->size() : 0); }
  };
  using OnText = std::function<void(std::string_view text)>;

  /// @param onText takes each text message; binary ones are refused, since nobody may publish
  WebSocket(const Limits& limits, OnText onText);
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  void receive(std::string_view bytes);
  /// @return how many of the oldest waiting messages made place
  std::size_t send(Message message);
  /// Begins the end. @param status of RFC 6455, section 7.4
  void close(std::uint16_t status, std::string_view reason);

  /// Bytes that are to be written next; empty: none.
  std::string_view output();
  void written(std::size_t count);
  /// Nothing more will come of it once output() is written.
  bool isOver() const;

 private:
  struct Callbacks;
  void fill();

  const Limits limits_;
  const OnText onText_;
  wslay_event_context* context_ = nullptr;
  std::string_view in_;          // of receive(), while it runs
  std::string out_;              // framed
  std::deque<Message> waiting_;  // the oldest first
  std::size_t unsent_ = 0;       // [bytes] of those
  Message sending_;              // that libwslay frames
  std::size_t sent_ = 0;         // [bytes] of it
  bool broken_ = false;
};

}  // namespace slam
