// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <span>
#include <string>

#include "bus/udpm/multicast_route.hpp"
#include "bus/udpm/udpm_url.hpp"

namespace slam {

/// Sends LCM messages from a real-time thread, by a socket of its own: nobody else's message is waited for. Opening
/// allocates and may wait, so another thread does it (LcmLink::tend()) and hands the socket over.
class LcmSender {
 public:
  struct Outcome {
    bool sent = false;
    int error = 0;  ///< errno of an attempt that failed; 0: there was none, because nothing is open
  };

  explicit LcmSender(const UdpmUrl& url) : url_(url), route_(url) {}
  ~LcmSender();
  LcmSender(const LcmSender&) = delete;
  LcmSender& operator=(const LcmSender&) = delete;

  // The opening thread's.
  /// Opens a socket in place of the present one, on the interface that the route goes to.
  void open(int interface);
  void close();
  void collect();  ///< deletes what the sending thread has given back

  /// The sending thread's; does not wait, lock or allocate.
  Outcome publish(const std::string& channel, std::span<const std::uint8_t> data);

 private:
  struct Socket {
    std::unique_ptr<lcm::LCM> lcm;  // nullptr: closed
    int interface = 0;
  };
  void hand(std::unique_ptr<Socket> next);
  void take();

  const UdpmUrl url_;
  MulticastRoute route_;
  std::unique_ptr<Socket> socket_;      // sends
  std::atomic<Socket*> next_{nullptr};  // to the sending thread
  std::atomic<Socket*> used_{nullptr};  // back
};

}  // namespace slam
