// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/logs/log_archive.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>

#include "tools/files.hpp"
#include "tools/unzip.hpp"

namespace slam::log_archive_test {
namespace {

namespace fs = std::filesystem;
using testing::Pair;

class Archive : public testing::Test {
 protected:
  Archive() {
    for (const char* run : {"logs/run-1", "logs/run-2"}) fs::create_directories(files_ / run);
    files_.write("logs/run-1/0001.lcm", std::string(1'000'000, 'a'));
    files_.write("logs/run-2/0001.lcm", "first");
    files_.write("logs/run-2/0002.lcm", "second");
    files_.write("secret", "not yours");
    fs::create_symlink("../../secret", files_ / "logs/run-2/link");
  }

  test::Folder files_;
};

TEST_F(Archive, HoldsEachFileOfEachRunAndNoLink) {
  LogArchive archive{LogFolder(files_ / "logs")};
  std::string sent;
  std::size_t most = 0;
  for (bool more = true; more;) {
    const std::size_t before = sent.size();
    more = archive.next([&](std::string_view bytes) { return sent.append(bytes), true; });
    most = std::max(most, sent.size() - before);
  }
  EXPECT_LT(most, 400'000U) << "in parts, whatever the size of a log";
  EXPECT_THAT(test::unzipped(files_.write("all.zip", sent)),
              testing::ElementsAre(Pair("run-1/0001.lcm", std::string(1'000'000, 'a')), Pair("run-2/0001.lcm", "first"),
                                   Pair("run-2/0002.lcm", "second")));
}

TEST_F(Archive, PassesOverWhatWasRemovedMeanwhile) {
  LogArchive archive{LogFolder(files_ / "logs")};
  std::string sent;
  const ZipWriter::Sink sink = [&](std::string_view bytes) { return sent.append(bytes), true; };
  ASSERT_TRUE(archive.next(sink));
  fs::remove(files_ / "logs/run-1/0001.lcm");  // is being sent
  fs::remove(files_ / "logs/run-2/0001.lcm");
  while (archive.next(sink)) {
  }
  const auto entries = test::unzipped(files_.write("all.zip", sent));
  EXPECT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries.at("run-1/0001.lcm").size(), 1'000'000U);
  EXPECT_EQ(entries.at("run-2/0002.lcm"), "second");
}

TEST_F(Archive, EndsWithWhoAskedAndIsEmptyWithoutLogs) {
  LogArchive archive{LogFolder(files_ / "logs")};
  EXPECT_THROW(while (archive.next([](std::string_view) { return false; })){}, std::runtime_error);
  LogArchive none{LogFolder(files_ / "none")};
  std::string sent;
  EXPECT_FALSE(none.next([&](std::string_view bytes) { return sent.append(bytes), true; }));
  EXPECT_EQ(sent.substr(0, 4), "PK\5\6") << "a zip file without entries";
}

}  // namespace
}  // namespace slam::log_archive_test
