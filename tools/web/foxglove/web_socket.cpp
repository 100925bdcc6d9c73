// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/web_socket.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <sys/types.h>
#include <utility>
#include <wslay/wslay.h>

namespace slam {

struct WebSocket::Callbacks {
  static ssize_t receive(wslay_event_context* context, std::uint8_t* bytes, std::size_t size, int, void* user) {
    auto& in = static_cast<WebSocket*>(user)->in_;
    const std::size_t count = std::min(size, in.size());
    if (count == 0) {
      wslay_event_set_error(context, WSLAY_ERR_WOULDBLOCK);
      return -1;
    }
    std::memcpy(bytes, in.data(), count);
    in.remove_prefix(count);
    return static_cast<ssize_t>(count);
  }

  static ssize_t send(wslay_event_context* context, const std::uint8_t* bytes, std::size_t size, int, void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    if (self.out_.size() >= self.limits_.out_buffer) {
      wslay_event_set_error(context, WSLAY_ERR_WOULDBLOCK);
      return -1;
    }
    self.out_.append(reinterpret_cast<const char*>(bytes), size);
    return static_cast<ssize_t>(size);
  }

  /// Of the message that is being sent.
  static ssize_t read(wslay_event_context*, std::uint8_t* bytes, std::size_t size, const wslay_event_msg_source* source,
                      int* is_end, void*) {
    auto& self = *static_cast<WebSocket*>(source->data);
    const Message& message = self.sending_;
    const std::string_view head = message.head;
    const std::string_view body = message.body ? std::string_view(*message.body) : std::string_view();
    const std::string_view part =
        self.sent_ < head.size() ? head.substr(self.sent_) : body.substr(self.sent_ - head.size());
    const std::size_t count = std::min(size, part.size());
    std::memcpy(bytes, part.data(), count);
    self.sent_ += count;
    *is_end = self.sent_ == message.size() ? 1 : 0;
    return static_cast<ssize_t>(count);
  }

  static void take(wslay_event_context*, const wslay_event_on_msg_recv_arg* message, void* user) {
    auto& self = *static_cast<WebSocket*>(user);
    if (message->opcode == WSLAY_TEXT_FRAME)
      self.onText_({reinterpret_cast<const char*>(message->msg), message->msg_length});
    if (message->opcode == WSLAY_BINARY_FRAME) self.close(WSLAY_CODE_UNSUPPORTED_DATA, "nothing is taken as binary");
  }
};

WebSocket::WebSocket(const Limits& limits, OnText onText) : limits_(limits), onText_(std::move(onText)) {
  const wslay_event_callbacks callbacks{Callbacks::receive, Callbacks::send, nullptr, nullptr, nullptr, nullptr,
                                        Callbacks::take};
  if (wslay_event_context_server_init(&context_, &callbacks, this) != 0) throw std::bad_alloc();
  wslay_event_config_set_max_recv_msg_length(context_, limits_.longest);
}

WebSocket::~WebSocket() { wslay_event_context_free(context_); }

void WebSocket::receive(std::string_view bytes) {
  in_ = bytes;
  while (!in_.empty() && !broken_ && wslay_event_get_read_enabled(context_) != 0) {
    broken_ = wslay_event_recv(context_) != 0 || wslay_event_get_queued_msg_count(context_) > limits_.most_answers;
  }
  in_ = {};
}

std::size_t WebSocket::send(Message message) {
  if (wslay_event_get_close_sent(context_) != 0) return 0;
  unsent_ += message.size();
  waiting_.push_back(std::move(message));
  std::size_t dropped = 0;
  for (; unsent_ > limits_.most_unsent && waiting_.size() > 1; ++dropped) {
    unsent_ -= waiting_.front().size();
    waiting_.pop_front();
  }
  return dropped;
}

void WebSocket::close(std::uint16_t status, std::string_view reason) {
  wslay_event_queue_close(context_, status, reinterpret_cast<const std::uint8_t*>(reason.data()), reason.size());
  wslay_event_shutdown_read(context_);
  waiting_.clear();
  unsent_ = 0;
}

/// Gives libwslay one message after another, so that those behind can still make place.
void WebSocket::fill() {
  if (wslay_event_get_close_sent(context_) != 0) waiting_.clear(), unsent_ = 0;
  while (out_.size() < limits_.out_buffer && !broken_) {
    if (wslay_event_get_queued_msg_count(context_) == 0 && !waiting_.empty()) {
      sending_ = std::move(waiting_.front());
      waiting_.pop_front();
      unsent_ -= sending_.size();
      sent_ = 0;
      const std::uint8_t opcode = sending_.binary ? WSLAY_BINARY_FRAME : WSLAY_TEXT_FRAME;
      const wslay_event_fragmented_msg part{opcode, {.data = this}, Callbacks::read};
      wslay_event_queue_fragmented_msg(context_, &part);
    }
    if (wslay_event_want_write(context_) == 0) return;
    broken_ = wslay_event_send(context_) != 0;
  }
}

std::string_view WebSocket::output() {
  fill();
  return out_;
}

void WebSocket::written(std::size_t count) { out_.erase(0, count); }

bool WebSocket::isOver() const {
  if (broken_) return true;
  const bool reads = wslay_event_want_read(context_) != 0;
  return !reads && wslay_event_want_write(context_) == 0 && waiting_.empty() && out_.empty();
}

}  // namespace slam
