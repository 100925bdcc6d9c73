// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <functional>
#include <string>
#include <string_view>

#include "core/timestamp.hpp"
#include "tools/web/http_library.hpp"

namespace slam {

/// One request's connection for cpp-httplib, whose own waits for each byte anew: here the whole request has a deadline
/// and a size, and the answer must be taken at a least rate. Does not own the socket.
class HttpConnection : public httplib::Stream {
 public:
  struct Limits {
    Duration request = std::chrono::seconds(5);         ///< from the first byte waited for to the last of the body
    std::size_t request_size = 32 * 1024;               ///< [bytes] head and body
    Duration answer = std::chrono::seconds(10);         ///< to begin with ...
    double least_rate = 20e3;                           ///< [bytes/s] ... and for each byte sent so much longer
    Duration crowded = std::chrono::milliseconds(500);  ///< without any progress, while others wait for its thread
  };

  /// @param address of who is at the other end @param isCrowded whether others wait for the thread that answers
  HttpConnection(int socket, const Limits& limits, std::string address = "", std::function<bool()> isCrowded = nullptr);

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* bytes, std::size_t size) override;
  ssize_t write(const char* bytes, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int&) const override { ip = address_; }
  void get_local_ip_and_port(std::string&, int&) const override {}
  /// What came behind the request.
  std::string_view rest() const { return {buffer_.data() + begin_, end_ - begin_}; }
  socket_t socket() const override { return socket_; }

 private:
  bool wait(short event, Timestamp deadline) const;
  bool waitForRoom() const;
  Timestamp answerDeadline() const;

  const int socket_;
  const Limits limits_;
  const std::string address_;
  const std::function<bool()> isCrowded_;
  const Timestamp read_by_;
  std::size_t taken_ = 0, sent_ = 0;  // [bytes]
  Timestamp answered_{};              // when the answer began
  Timestamp progress_{};              // when some of it was taken last
  std::array<char, 4096> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what of the buffer is not read yet
};

}  // namespace slam
