// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <boost/lockfree/policies.hpp>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <utility>

namespace slam {

/// Bounded queue from one thread to one other, lock-free and without allocation after construction. When it is full
/// the new element is dropped and counted: a producer never pops.
template <typename T>
class SpscQueue {
 public:
  explicit SpscQueue(std::size_t capacity) : queue_(capacity) {}

  bool tryPush(const T& value) {
    if (queue_.push(value)) return true;
    drops_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// Calls consume(T&) for each element that is there. @return their number
  template <typename Consume>
  std::size_t drain(Consume&& consume) {
    return queue_.consume_all(std::forward<Consume>(consume));
  }
  /// Calls consume(T&) for the oldest element. @return false when there is none
  template <typename Consume>
  bool popOne(Consume&& consume) {
    return queue_.consume_one(std::forward<Consume>(consume));
  }
  bool hasRoom() const { return queue_.write_available() > 0; }  ///< producer's side

  std::uint64_t drops() const { return drops_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T> queue_;
  std::atomic<std::uint64_t> drops_{0};
};

/// The end of a queue that gives: whoever has it cannot take.
template <typename T>
class Producer {
 public:
  Producer(SpscQueue<T>& queue) : queue_(&queue) {}
  bool tryPush(const T& value) const { return queue_->tryPush(value); }
  bool hasRoom() const { return queue_->hasRoom(); }

 private:
  SpscQueue<T>* queue_;
};

/// The end of a queue that takes: whoever has it cannot give.
template <typename T>
class Consumer {
 public:
  Consumer(SpscQueue<T>& queue) : queue_(&queue) {}
  template <typename Consume>
  std::size_t drain(Consume&& consume) const {
    return queue_->drain(std::forward<Consume>(consume));
  }
  template <typename Consume>
  bool popOne(Consume&& consume) const {
    return queue_->popOne(std::forward<Consume>(consume));
  }

 private:
  SpscQueue<T>* queue_;
};

}  // namespace slam
