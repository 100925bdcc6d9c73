// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/certificate.hpp"

#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "config/loader.hpp"
#include "tools/files.hpp"

namespace slam::certificate_test {
namespace {

using testing::HasSubstr;

class CertificateTest : public testing::Test {
 protected:
  test::Folder folder_;
  std::string state_ = folder_ / "state";
  WebConfig web_;
};

TEST_F(CertificateTest, IsMadeOnceWithAKeyForNobodyElse) {
  const TlsContext first = tlsContextOf(web_, state_, {"robot", "192.168.0.7", "::1"});
  EXPECT_TRUE(first.is_new);
  EXPECT_THAT(first.fingerprint, testing::MatchesRegex("([0-9A-F][0-9A-F]:)+[0-9A-F][0-9A-F]"));
  EXPECT_EQ(first.fingerprint.size(), 32U * 3 - 1);
  struct stat file {};
  ASSERT_EQ(::stat((state_ + "/key.pem").c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777, 0600U);
  const TlsContext second = tlsContextOf(web_, state_, {});
  EXPECT_FALSE(second.is_new);
  EXPECT_EQ(second.fingerprint, first.fingerprint);
  EXPECT_EQ(fingerprintOf(certificateFileOf(web_, state_)), first.fingerprint);
}

TEST_F(CertificateTest, NamesTheComputerAndIsForServersAlone) {
  tlsContextOf(web_, state_, {"robot", "192.168.0.7", "no name, but words", "fe80::1"});
  std::FILE* pipe = ::popen(("openssl x509 -noout -text -in " + certificateFileOf(web_, state_)).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text(16'384, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), pipe));
  ASSERT_EQ(::pclose(pipe), 0);
  EXPECT_THAT(text, HasSubstr("DNS:robot, IP Address:192.168.0.7, IP Address:FE80"));
  EXPECT_THAT(text, HasSubstr("TLS Web Server Authentication"));
  EXPECT_THAT(text, HasSubstr("CA:FALSE"));
}

TEST_F(CertificateTest, IsMadeAnewWhereItIsDamaged) {
  const TlsContext first = tlsContextOf(web_, state_, {"robot"});
  folder_.write("state/certificate.pem", "");
  const TlsContext second = tlsContextOf(web_, state_, {"robot"});
  EXPECT_TRUE(second.is_new);
  EXPECT_NE(second.fingerprint, first.fingerprint);
}

TEST_F(CertificateTest, IsTheOneThatIsConfigured) {
  const std::string own = folder_ / "own";
  const TlsContext made = tlsContextOf(web_, own, {"robot"});
  web_.certificate = own + "/certificate.pem";
  web_.key = own + "/key.pem";
  EXPECT_EQ(tlsContextOf(web_, state_, {}).fingerprint, made.fingerprint);
  EXPECT_FALSE(std::filesystem::exists(state_));
}

TEST_F(CertificateTest, IsRefusedWithTheKeyToChange) {
  const auto refusal = [&] { return test::refusalOf([&] { tlsContextOf(web_, state_, {}); }); };
  tlsContextOf(web_, folder_ / "a", {});
  tlsContextOf(web_, folder_ / "b", {});
  web_.certificate = folder_ / "a/certificate.pem";
  web_.key = folder_ / "b/key.pem";
  EXPECT_THAT(refusal(), HasSubstr("web.key"));
  web_.key = folder_ / "none.pem";
  EXPECT_THAT(refusal(), HasSubstr("none.pem"));
  web_.certificate = folder_ / "none.pem";
  EXPECT_THAT(refusal(), HasSubstr("web.certificate: cannot read"));
  web_.certificate = folder_ / "a/key.pem";
  EXPECT_THAT(refusal(), HasSubstr("no certificate in PEM"));
}

TEST_F(CertificateTest, IsRefusedWhereItCannotBeWritten) {
  EXPECT_THAT(test::refusalOf([&] { tlsContextOf(web_, "/proc/slamd-web", {}); }), HasSubstr("cannot write"));
}

}  // namespace
}  // namespace slam::certificate_test
