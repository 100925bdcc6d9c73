// SPDX-License-Identifier: BSD-3-Clause
// The input is what comes on a WebSocket behind its handshake: frames, or, after a 'T', the text of one message.
#include <string>

#include "fuzz/fuzzing.hpp"
#include "tools/web/foxglove/foxglove_session.hpp"
#include "tools/web/foxglove/web_socket.hpp"

namespace slam {
namespace {

void check(std::string_view bytes, std::size_t part) {
  FoxgloveSession session;
  WebSocket::Limits limits;
  int faults = 0;
  bool ended = false;
  WebSocket socket(limits, [&](std::string_view text) {
    FUZZ_CHECK(text.size() <= limits.longest);
    const auto reply = session.take(text);
    FUZZ_CHECK(reply.text.size() < 400);
    faults += !reply.text.empty();
    FUZZ_CHECK(reply.ends == (faults > FoxgloveSession::kMostFaults));
    ended = ended || reply.ends;
  });
  std::size_t sent = 0;
  for (std::size_t i = 0; i < bytes.size() && !socket.isOver(); i += part) {
    socket.receive(bytes.substr(i, part));
    const std::string_view output = socket.output();
    FUZZ_CHECK(output.size() <= limits.out_buffer + limits.longest);
    sent += output.size();
    socket.written(output.size());
  }
  FUZZ_CHECK(sent <= 4 * bytes.size() + 400);  // an answer is no amplifier
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.starts_with('T')) {
    slam::FoxgloveSession().take(bytes.substr(1));
  } else {
    slam::check(bytes, size + 1);
    slam::check(bytes, 7);
  }
  return 0;
}
