// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/web_address.hpp"

#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

#include "config/loader.hpp"
#include "tools/files.hpp"

namespace slam::web_address_test {
namespace {

using testing::HasSubstr;

TEST(WebAddress, IsThatOfTheConfiguration) {
  WebConfig web;
  web.address = "192.168.1.5";
  web.port = 8081;
  EXPECT_EQ(webAddressOf(web), "http://192.168.1.5:8081/");
  web.tls = true;
  EXPECT_EQ(webAddressOf(web), "https://192.168.1.5:8081/");
  web.address = "fd00::1";
  EXPECT_EQ(webAddressOf(web), "https://[fd00::1]:8081/");
  web.address = "0.0.0.0";
  EXPECT_THAT(webAddressOf(web), HasSubstr(".local:8081/"));
}

/// The squares of a code, two in a character.
std::vector<std::string> rowsOf(const std::string& code) {
  std::vector<std::string> rows;
  for (std::size_t at = 0; at < code.size();) {
    std::string upper, lower;
    while (code[at] != '\n') {
      const std::string mark = code[at] == ' ' ? " " : code.substr(at, 3);
      upper += mark == "█" || mark == "▀" ? '1' : '0';
      lower += mark == "█" || mark == "▄" ? '1' : '0';
      at += mark.size();
    }
    ++at;
    rows.push_back(upper);
    rows.push_back(lower);
  }
  return rows;
}

TEST(WebAddress, IsReadFromItsCodeByAnotherProgram) {
  if (std::system("command -v zbarimg >/dev/null") != 0) GTEST_SKIP() << "no zbarimg (package zbar-tools)";
  const test::Folder files;
  const std::string address = "https://robot.local:8080/#token=0123456789abcdef0123456789abcdef";
  const std::vector<std::string> rows = rowsOf(qrCodeOf(address));
  constexpr std::size_t kPixels = 6;  // of a square's side
  std::string picture =
      "P1 " + std::to_string(kPixels * rows[0].size()) + " " + std::to_string(kPixels * rows.size()) + "\n";
  for (const std::string& row : rows) {
    std::string line;
    for (const char square : row) line.append(kPixels, square);
    for (std::size_t i = 0; i < kPixels; ++i) picture += line + "\n";
  }
  files.write("code.pbm", picture);
  std::FILE* pipe = ::popen(("zbarimg -q --raw " + (files / "code.pbm").string()).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  char text[256] = {};
  const std::size_t size = std::fread(text, 1, sizeof text - 1, pipe);
  EXPECT_EQ(::pclose(pipe), 0);
  EXPECT_EQ(std::string(text, size), address + "\n");
}

TEST(WebAddress, HasNoCodeWhereNoPhoneReachesIt) {
  WebConfig web;
  web.address = "127.0.0.1";
  EXPECT_THAT([&] { printWebAddress(web, true); }, testing::ThrowsMessage<ConfigError>(HasSubstr("web.address")));
  EXPECT_THROW(qrCodeOf(std::string(5000, 'x')), std::runtime_error);
}

}  // namespace
}  // namespace slam::web_address_test
