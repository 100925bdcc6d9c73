// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/host_guard.hpp"

#include <gtest/gtest.h>

namespace slam::host_guard_test {
namespace {

int statusOf(const std::vector<std::string>& hosts, const std::string& address = "127.0.0.1") {
  httplib::Request request;
  for (const std::string& host : hosts) request.headers.emplace("Host", host);
  httplib::Response response;
  return HostGuard(address).mayEnter(request, response) ? 200 : response.status;
}

TEST(HostGuard, AdmitsThisHostAlone) {
  EXPECT_EQ(statusOf({"127.0.0.1:8080"}), 200);
  EXPECT_EQ(statusOf({"localhost"}), 200);
  EXPECT_EQ(statusOf({"[::1]:8080"}), 200);
  EXPECT_EQ(statusOf({"evil.example:8080"}), 421);
  EXPECT_EQ(statusOf({"localhost.evil.example"}), 421);
  EXPECT_EQ(statusOf({}), 400);
  EXPECT_EQ(statusOf({"localhost", "evil.example"}), 400);
  EXPECT_EQ(statusOf({"evil.example@localhost"}), 400);
}

TEST(HostGuard, AdmitsTheConfiguredName) { EXPECT_EQ(statusOf({"Robot.example:8080"}, "robot.example"), 200); }

}  // namespace
}  // namespace slam::host_guard_test
