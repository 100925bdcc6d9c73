// SPDX-License-Identifier: BSD-3-Clause
#include "problems/problem.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <string>
#include <thread>

#include "support/allocations.hpp"

namespace slam::problem_test {
namespace {

constexpr ProblemKind kSlow{"slow", "{0} sends {#0.1} Hz of {#1}, node 0x{#2x3} of {1}", "slamd goes on",
                            "set {1} up{2}"};
constexpr ProblemKind kGone{"gone", "it is gone", "", "plug it in"};

TEST(Problem, FillsTheWordsOfItsRow) {
  const Problem slow(kSlow, {4.96, 9.6, 27.0}, {"left", "can0", "!"});
  EXPECT_EQ(slow.cause(), "left sends 5.0 Hz of 10, node 0x01b of can0");
  EXPECT_EQ(slow.words(), slow.cause() + "; slamd goes on; fix: set can0 up!");
  EXPECT_EQ(slow.words("slamd waits"), slow.words()) << "the row knows better";
  EXPECT_EQ(Problem(kGone).words(), "it is gone: plug it in");
  EXPECT_EQ(Problem(kGone).words("slamd waits"), "it is gone; slamd waits; fix: plug it in");
  EXPECT_STREQ(slow.id(), "slow");
  EXPECT_EQ(slow.texts(), (std::vector<std::string>{"left", "can0", "!"}));
  EXPECT_EQ(Problem(kSlow, {}, {"left"}).texts(), std::vector<std::string>{"left"});
  EXPECT_TRUE(Problem(kGone).texts().empty());
}

TEST(Problem, IsNoneWithoutARow) {
  EXPECT_FALSE(Problem());
  EXPECT_EQ(Problem().words(), "");
  EXPECT_STREQ(Problem().id(), "");
}

TEST(Problem, IsTheSameWhateverItsNumbersAndDetails) {
  const Problem slow(kSlow, {5.0}, {"left", "can0", "!"});
  EXPECT_TRUE(slow.isSame({kSlow, {4.0}, {"left", "can0", "?"}}));
  EXPECT_FALSE(slow.isSame({kSlow, {5.0}, {"left", "can1", "!"}}));
  EXPECT_FALSE(slow.isSame({kSlow, {5.0}, {"right", "can0", "!"}}));
  EXPECT_FALSE(slow.isSame(kGone));
  EXPECT_FALSE(slow == Problem(kSlow, {4.0}, {"left", "can0", "!"}));
}

TEST(Problem, CutsTextsThatAreTooLong) {
  const std::string path(1000, 'x');
  const Problem problem(kSlow, {}, {path, path});
  EXPECT_EQ(problem.cause().find("x sends"), Problem::kTextSize - 2);
  EXPECT_EQ(problem.fix(), "set  up");
}

TEST(Problem, AllocatesNothing) {
  SharedProblem shared;
  const std::uint64_t before = test::allocationCount();
  shared.store({kSlow, {5.0}, {"left"}});
  const Problem problem = shared.load();
  EXPECT_TRUE(problem.isSame(shared.load()));
  EXPECT_EQ(test::allocationCount(), before);
}

TEST(SharedProblem, IsNeverReadHalfWritten) {
  SharedProblem shared;
  std::atomic<bool> ends{false};
  std::thread writer([&] {
    for (int i = 0; !ends; ++i) {
      const char digit = static_cast<char>('0' + i % 10);
      shared.store(
          {kSlow, {i % 10 * 1.0, 0.0, 0.0, i % 10 * 1.0}, {std::string_view(&digit, 1), std::string(300, digit)}});
    }
  });
  for (int i = 0; i < 20'000; ++i) {
    const Problem problem = shared.load();
    if (!problem) continue;
    const auto digit = static_cast<char>('0' + static_cast<int>(problem.numbers()[0]));
    ASSERT_EQ(problem.numbers()[3], problem.numbers()[0]);
    ASSERT_EQ(problem.fix(), "set " + std::string(300, digit) + " up");
  }
  ends = true;
  writer.join();
}

}  // namespace
}  // namespace slam::problem_test
