// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <memory>
#include <semaphore>
#include <string>
#include <thread>
#include <utility>

#include "drivers/byte_stream.hpp"

namespace slam {

/// Opens and closes a port in a thread of its own: both allocate or free, and may wait for a kernel driver, which a
/// real-time thread must not. Asking and taking neither wait nor allocate. One thread asks.
class BackgroundOpener {
 public:
  BackgroundOpener(std::string path, int baud, PortOpener open = openPort)
      : path_(std::move(path)), baud_(baud), open_(std::move(open)), thread_([this] { work(); }) {}
  ~BackgroundOpener() {
    ending_ = true;
    asked_.release();
    thread_.join();
  }
  BackgroundOpener(const BackgroundOpener&) = delete;
  BackgroundOpener& operator=(const BackgroundOpener&) = delete;

  /// Before ask(). @param baud [bit/s]
  void useBaud(int baud) { baud_ = baud; }
  /// Not again before take().
  void ask() {
    wanted_.store(true, std::memory_order_release);
    asked_.release();
  }
  /// Not again before isClosed().
  void close(std::unique_ptr<ByteStream> stream) {
    closing_ = std::move(stream);
    closes_.store(true, std::memory_order_release);
    asked_.release();
  }
  bool isClosed() const { return !closes_.load(std::memory_order_acquire); }
  bool isDone() const { return done_.load(std::memory_order_acquire); }
  /// After isDone().
  OpenedPort take() {
    done_.store(false, std::memory_order_relaxed);
    return std::exchange(result_, {});
  }

 private:
  void work() {
    for (asked_.acquire(); !ending_; asked_.acquire()) {
      if (closes_.load(std::memory_order_acquire)) {
        closing_.reset();
        closes_.store(false, std::memory_order_release);
      }
      if (!wanted_.exchange(false, std::memory_order_acquire)) continue;
      result_ = open_(path_, baud_);
      done_.store(true, std::memory_order_release);
    }
  }

  const std::string path_;
  int baud_;  // [bit/s] handed over by wanted_
  const PortOpener open_;
  std::counting_semaphore<> asked_{0};
  std::atomic<bool> wanted_{false}, done_{false}, closes_{false}, ending_{false};
  OpenedPort result_;
  std::unique_ptr<ByteStream> closing_;
  std::thread thread_;
};

}  // namespace slam
