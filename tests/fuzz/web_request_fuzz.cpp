// SPDX-License-Identifier: BSD-3-Clause
// The input is what a browser, or anybody, sends to slam-web.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <string>

#include "fuzz/fuzzing.hpp"
#include "tools/web/http_library.hpp"
#include "tools/web/web_server.hpp"

namespace slam {
namespace {

/// A connection that has said all it will.
class Recorded : public httplib::Stream {
 public:
  explicit Recorded(fuzz::Bytes request) : request_(request) {}
  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* bytes, std::size_t size) override {
    const std::size_t count = std::min(size, request_.size());
    if (count > 0) std::memcpy(bytes, request_.data(), count);
    request_ = request_.subspan(count);
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    answer.append(bytes, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return -1; }

  std::string answer;

 private:
  fuzz::Bytes request_;
};

class Site : public httplib::Server {
 public:
  Site() {
    setRoutes(*this, pages_, [](Successor) {});
  }

  void check(fuzz::Bytes request) {
    Recorded connection(request);
    bool closed = false;
    commanded_ = false;
    process_request(connection, true, closed, prepareRequest);
    const std::string& answer = connection.answer;
    const std::string text(request.begin(), request.end());
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    FUZZ_CHECK(!isWholeRequest(text) || text.find("\r\n\r\n") != std::string::npos);
    FUZZ_CHECK(answer.empty() || answer.starts_with("HTTP/1.1 "));
    FUZZ_CHECK(!answer.starts_with("HTTP/1.1 5") || answer.starts_with("HTTP/1.1 504"));
    FUZZ_CHECK(!commanded_ || text.find(kToken) != std::string::npos);
    const bool page = answer.starts_with("HTTP/1.1 200");
    FUZZ_CHECK(!page || lower.find("host:") != std::string::npos);  // RFC 9110, section 5.1: a name of any case
    FUZZ_CHECK(answer.size() < (1 << 20));
  }

 private:
  static constexpr const char* kToken = "secret-of-the-robot";
  bool commanded_ = false;
  SharedState shared_{Config{}};
  WebPages pages_{[] {
                    WebPages::Settings settings;
                    settings.web.commands = true;
                    settings.web.token = kToken;
                    settings.drives = true;
                    settings.logs = "/nonexistent";
                    return settings;
                  }(),
                  shared_,
                  [this](const WebCommand&) {
                    commanded_ = true;
                    return std::optional<ack_t>();
                  },
                  [this](const DriveRequest& request) {
                    commanded_ = true;
                    FUZZ_CHECK(std::abs(request.twist.vx) <= 10.0 && std::abs(request.twist.omega) <= 20.0);
                    return Problem();
                  }};
};

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static slam::Site site;
  site.check({data, size});
  return 0;
}
