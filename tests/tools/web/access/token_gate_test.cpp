// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/token_gate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::token_gate_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr const char* kToken = "correct horse battery";
constexpr const char* kBearer = "Bearer correct horse battery";

httplib::Headers with(const char* name, const std::string& value) {
  httplib::Headers headers;
  headers.emplace(name, value);
  return headers;
}

class Gate : public testing::Test {
 protected:
  Gate() {
    web_.read = WebReaders::kToken;
    web_.commands = true;
    web_.token = kToken;
  }
  int read(const httplib::Headers& headers) {
    httplib::Request request;
    request.headers = headers;
    httplib::Response response;
    return gate_.mayRead(request, response, now_) ? 200 : response.status;
  }
  int command(const httplib::Headers& headers) {
    httplib::Request request;
    request.headers = headers;
    httplib::Response response;
    return gate_.mayCommand(request, response, now_) ? 200 : response.status;
  }
  /// What a browser keeps and sends.
  std::string cookieFor(const std::string& token) {
    httplib::Request request;
    request.headers = with("Authorization", "Bearer " + token);
    httplib::Response response;
    if (!gate_.unlock(request, response, now_)) return "";
    const std::string cookie = response.get_header_value("Set-Cookie");
    EXPECT_THAT(cookie, HasSubstr("; HttpOnly; SameSite=Strict"));
    return cookie.substr(0, cookie.find(';'));
  }

  Timestamp now_{100s};
  WebConfig web_;
  TokenGate gate_{web_};
};

TEST_F(Gate, IsReadByAnybodyUnlessConfigured) {
  EXPECT_EQ(read({}), 401);
  web_.read = WebReaders::kAnybody;
  EXPECT_EQ(read({}), 200);
  EXPECT_EQ(command({}), 401);
}

TEST_F(Gate, IsReadWithTheTokenOrTheCookieForIt) {
  EXPECT_EQ(read(with("Authorization", kBearer)), 200);
  const std::string cookie = cookieFor(kToken);
  EXPECT_EQ(read(with("Cookie", cookie)), 200);
  EXPECT_EQ(read(with("Cookie", "other=1; " + cookie + "; more=2")), 200);
  EXPECT_THAT(cookie, testing::Not(HasSubstr(kToken)));
  EXPECT_EQ(command(with("Cookie", cookie)), 401) << "a browser sends it by itself";
  for (const char* wrong : {"", "slamd-read", "slamd-read=", "slamd-read=0123456789abcdef0123456789abcdef", ";;; ;"})
    EXPECT_EQ(read(with("Cookie", wrong)), 401) << wrong;
  EXPECT_EQ(read(with("Cookie", "x" + cookie)), 401);
  EXPECT_EQ(read(with("Cookie", cookie.substr(0, cookie.size() - 1))), 401);
}

TEST_F(Gate, GivesNoCookieForAWrongToken) { EXPECT_EQ(cookieFor("wrong horse battery"), ""); }

TEST_F(Gate, HasAnotherCookieForEachStart) {
  const TokenGate next(web_);
  httplib::Request request;
  request.headers = with("Cookie", cookieFor(kToken));
  httplib::Response response;
  EXPECT_FALSE(next.mayRead(request, response, now_));
}

TEST_F(Gate, SlowsDownWhoGuessesToRead) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(read(with("Authorization", "Bearer guess")), 401) << i;
  EXPECT_EQ(read(with("Authorization", kBearer)), 429);
  now_ += 2s;
  EXPECT_EQ(read(with("Authorization", kBearer)), 200);
}

TEST_F(Gate, ObeysNobodyWhereCommandsAreOff) {
  web_.commands = false;
  EXPECT_EQ(command(with("Authorization", kBearer)), 403);
  EXPECT_NE(cookieFor(kToken), "") << "it may be read";
  web_.read = WebReaders::kAnybody;
  EXPECT_EQ(cookieFor(kToken), "");
}

}  // namespace
}  // namespace slam::token_gate_test
