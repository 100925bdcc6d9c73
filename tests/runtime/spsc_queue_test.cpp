// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/spsc_queue.hpp"

#include <array>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "support/allocations.hpp"

namespace slam::spsc_queue_test {
namespace {

TEST(SpscQueue, DropsAndCountsWhatDoesNotFit) {
  SpscQueue<int> queue(3);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.tryPush(i));
  EXPECT_FALSE(queue.hasRoom());
  EXPECT_FALSE(queue.tryPush(3));
  EXPECT_FALSE(queue.tryPush(4));
  EXPECT_EQ(queue.drops(), 2U);

  int oldest = -1;
  EXPECT_TRUE(queue.popOne([&](int value) { oldest = value; }));
  EXPECT_EQ(oldest, 0);
  EXPECT_TRUE(queue.hasRoom());
  std::vector<int> rest;
  EXPECT_EQ(queue.drain([&](int value) { rest.push_back(value); }), 2U);
  EXPECT_THAT(rest, testing::ElementsAre(1, 2));
  EXPECT_FALSE(queue.popOne([](int) {}));
  EXPECT_EQ(queue.drain([](int) {}), 0U);
}

TEST(SpscQueue, DoesNotAllocateAfterConstruction) {
  SpscQueue<std::array<int, 100>> queue(8);
  EXPECT_EQ(test::allocationsDuring([&] {
              for (int i = 0; i < 20; ++i) queue.tryPush({});
              queue.drain([](const auto&) {});
            }),
            0U);
}

/// Several words each, so that a race would show as a torn element.
struct Element {
  std::array<int, 8> words{};
};

TEST(SpscQueue, HandsEveryElementOverInOrder) {
  constexpr int kCount = 200'000;
  SpscQueue<Element> queue(64);
  std::thread producer([&] {
    for (int i = 0; i < kCount; ++i) {
      Element element;
      element.words.fill(i);
      while (!queue.hasRoom()) std::this_thread::yield();
      ASSERT_TRUE(queue.tryPush(element));
    }
  });
  int next = 0, wrong = 0;
  const auto check = [&](const Element& element) {
    for (const int word : element.words) wrong += word != next ? 1 : 0;
    ++next;
  };
  while (next < kCount) {
    if (queue.drain(check) == 0 && !queue.popOne(check)) std::this_thread::yield();
  }
  producer.join();
  EXPECT_EQ(next, kCount);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(queue.drops(), 0U);
}

TEST(SpscQueue, LosesNoMoreThanItCounts) {
  constexpr int kCount = 200'000;
  SpscQueue<int> queue(16);
  std::atomic<bool> done{false};
  std::thread producer([&] {
    for (int i = 0; i < kCount; ++i) queue.tryPush(i);
    done = true;
  });
  int received = 0, last = -1;
  bool in_order = true;
  const auto check = [&](int value) {
    in_order = in_order && value > last;
    last = value;
    ++received;
  };
  while (!done) queue.drain(check);
  queue.drain(check);
  producer.join();
  EXPECT_TRUE(in_order);
  EXPECT_EQ(static_cast<std::uint64_t>(received) + queue.drops(), static_cast<std::uint64_t>(kCount));
}

}  // namespace
}  // namespace slam::spsc_queue_test
