// SPDX-License-Identifier: BSD-3-Clause
#include "vm/write_log.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <initializer_list>
#include <iterator>
#include <set>
#include <unistd.h>
#include <utility>

namespace slam::test::write_log_test {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kSector = 512;

class WriteLogTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("write_log_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "disk", std::ios::binary) << std::string(16 * kSector, '.');
    put(0, 0, 0, "");
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A log's entry; `text` repeated is its data.
  void put(std::uint64_t sector, std::uint64_t sectors, std::uint64_t flags, const std::string& text) {
    if (log_.empty()) {
      number(0x6a736677736872), number(1), number(0);
      log_ += std::string("\0\2\0\0", 4);
      log_.resize(kSector);
      return;
    }
    number(sector), number(sectors), number(flags), number(0);
    log_.resize((log_.size() + kSector - 1) / kSector * kSector);
    for (std::size_t i = 0; i < sectors * kSector && !text.empty(); i += text.size()) log_ += text;
    ++log_[16];  // entries
  }
  void write(std::uint64_t sector, char letter, std::uint64_t flags = 0) {
    put(sector, 1, flags, std::string(1, letter));
  }
  void flush() { put(0, 0, 1, ""); }

  WriteLog read() const {
    std::ofstream(folder_ / "log", std::ios::binary) << log_;
    return WriteLog(folder_ / "log");
  }
  /// A letter for each sector; '?' where it is of two kinds.
  std::string disk() const {
    std::ifstream in(folder_ / "disk", std::ios::binary);
    const std::string all{std::istreambuf_iterator<char>(in), {}};
    std::string letters;
    for (std::size_t at = 0; at < all.size(); at += kSector) {
      const bool same = all.find_first_not_of(all[at], at) >= at + kSector;
      letters += same ? all[at] : '?';
    }
    return letters;
  }

  fs::path folder_;
  std::string log_;
  std::mt19937_64 random_{7};

 private:
  void number(std::uint64_t value) {
    for (int byte = 0; byte < 8; ++byte) log_ += static_cast<char>(value >> (8 * byte));
  }
};

TEST_F(WriteLogTest, KeepsWhatWasFlushedAndWhatWasWrittenThrough) {
  write(1, 'a'), write(2, 'b'), write(1, 'c'), flush(), write(3, 'd', 2);
  for (int trial = 0; trial < 50; ++trial) {
    const auto cut = read().apply(folder_ / "disk", 99, random_);
    EXPECT_EQ(disk(), ".cbd............");
    EXPECT_EQ(cut.durable, 4);
    EXPECT_EQ(cut.unflushed, 0);
  }
}

TEST_F(WriteLogTest, LosesAnyPartOfWhatWasNotFlushed) {
  write(1, 'a'), flush(), write(2, 'b'), write(3, 'c');
  std::set<std::string> seen;
  for (int trial = 0; trial < 200; ++trial) {
    std::ofstream(folder_ / "disk", std::ios::binary) << std::string(16 * kSector, '.');
    const auto cut = read().apply(folder_ / "disk", 99, random_);
    EXPECT_EQ(cut.unflushed, 2);
    EXPECT_LE(cut.kept + cut.torn, 2);
    seen.insert(disk().substr(0, 4));
  }
  EXPECT_EQ(seen, (std::set<std::string>{".a..", ".ab.", ".a.c", ".abc"}));
}

TEST_F(WriteLogTest, TearsAWriteBetweenPhysicalBlocksAndNowhereElse) {
  // Four blocks of 4 KiB are touched: the last three sectors of one, two whole ones, the first sector of another.
  flush(), put(5, 20, 0, "x");
  const std::string none(64, '.');
  std::set<std::string> seen;
  for (int trial = 0; trial < 500; ++trial) {
    std::ofstream(folder_ / "disk", std::ios::binary) << std::string(64 * kSector, '.');
    read().apply(folder_ / "disk", 99, random_);
    const std::string left = disk();
    EXPECT_EQ(left.substr(0, 5) + left.substr(25), none.substr(20));
    for (const auto& [begin, size] : std::initializer_list<std::pair<int, int>>{{5, 3}, {8, 8}, {16, 8}, {24, 1}}) {
      EXPECT_EQ(left.substr(begin, size), std::string(size, left[begin]));
    }
    seen.insert(left);
  }
  EXPECT_EQ(seen.size(), 16U);
}

TEST_F(WriteLogTest, CutsAtTheGivenPlaceAndForgetsLaterFlushes) {
  write(1, 'a'), flush(), write(2, 'b'), flush(), write(3, 'c'), flush();
  const auto cut = read().apply(folder_ / "disk", 2, random_);
  EXPECT_EQ(disk().substr(0, 4), ".a..");
  EXPECT_EQ(cut.durable, 1);
  EXPECT_EQ(cut.unflushed, 0);
}

TEST_F(WriteLogTest, ReadsALogThatEndsAnywhere) {
  write(1, 'a'), flush(), put(2, 3, 0, "b"), flush();
  const std::string whole = log_;
  for (std::size_t size = 0; size <= whole.size(); size += 16) {
    log_ = whole.substr(0, size);
    if (size == 0) {
      EXPECT_TRUE(read().entries().empty());
    } else if (size < 28) {
      EXPECT_THROW(read(), std::runtime_error) << size;
    } else {
      const WriteLog log = read();
      EXPECT_LE(log.entries().size(), 4U);
      log.apply(folder_ / "disk", 99, random_);
    }
  }
  EXPECT_EQ(read().entries().size(), 4U);
}

TEST_F(WriteLogTest, RefusesWhatIsNoLog) {
  log_ = std::string(4096, 'n');
  EXPECT_THROW(read(), std::runtime_error);
}

}  // namespace
}  // namespace slam::test::write_log_test
