// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mutex>
#include <string>

#include "config/config.hpp"
#include "core/timestamp.hpp"
#include "problems/answer.hpp"
#include "tools/web/http_library.hpp"
#include "tools/web/token_throttle.hpp"

namespace slam {

/// Who may read and who may command: who sends the token, and for reading also who has the cookie that a browser got
/// for it, because links and streams of events carry no token. Safe from several threads.
class TokenGate {
 public:
  /// @param web with its token
  explicit TokenGate(const WebConfig& web);

  /// @return false, with the refusal in `response`
  bool mayRead(const httplib::Request& request, httplib::Response& response, Timestamp now) const;
  /// The same for what changes something; a cookie is not enough, because a browser sends it by itself.
  bool mayCommand(const httplib::Request& request, httplib::Response& response, Timestamp now) const;
  /// Whether the token is right; then the browser gets the cookie. @return, as mayRead()
  bool unlock(const httplib::Request& request, httplib::Response& response, Timestamp now) const;

 private:
  bool hasToken(const httplib::Request& request, httplib::Response& response, Timestamp now) const;
  bool hasCookie(const httplib::Request& request) const;

  const WebConfig& web_;
  const std::string cookie_;  // another one for each start of the program
  mutable std::mutex guessing_;
  mutable TokenThrottle throttle_{TokenThrottle::Limits{}};
};

/// 128 bits that nobody can guess, in hexadecimal digits.
std::string drawnSecret();

/// Ends a request. @param words what is wrong, for people
void refuse(httplib::Response& response, int status, const std::string& words);
/// As well with the rows that the words are made of, in the header kPartsHeader: a list of `problem` (docs/api.md).
void refuse(httplib::Response& response, int status, const Answer& why);
inline constexpr const char* kPartsHeader = "Slamd-Parts";

}  // namespace slam
