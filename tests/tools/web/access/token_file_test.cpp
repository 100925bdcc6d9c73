// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/token_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/loader.hpp"
#include "tools/files.hpp"

namespace slam::token_file_test {
namespace {

using testing::HasSubstr;

constexpr const char* kToken = "correct horse battery";

TEST(TokenFile, IsReadFromItsFile) {
  const test::Folder files;
  files.write("token", "correct horse battery\n");
  WebConfig web;
  web.token_file = (files / "token").string();
  EXPECT_EQ(tokenOf(web), "") << "nothing needs it";
  web.commands = true;
  EXPECT_EQ(tokenOf(web), kToken);
  web.token = "of the configuration";
  EXPECT_EQ(tokenOf(web), "of the configuration");
}

TEST(TokenFile, IsRefusedWithTheFix) {
  const test::Folder files;
  WebConfig web;
  web.read = WebReaders::kToken;
  web.token_file = (files / "token").string();
  EXPECT_THAT([&] { tokenOf(web); }, testing::ThrowsMessage<ConfigError>(HasSubstr("No such file")));
  for (const std::string& text :
       {std::string(), std::string("short\n"), std::string("two lines of\nwords in it\n"), std::string(5000, '\n')}) {
    files.write("token", text);
    EXPECT_THAT([&] { tokenOf(web); }, testing::ThrowsMessage<ConfigError>(HasSubstr("openssl rand -hex 16")));
  }
}

}  // namespace
}  // namespace slam::token_file_test
