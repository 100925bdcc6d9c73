// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <mutex>
#include <string>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/web/http_library.hpp"

namespace slam {

/// Whether a request is meant for this computer. Who asks for another host's page by this address was led here by a
/// trick (DNS rebinding). Safe from several threads.
class HostGuard {
 public:
  /// @param address that is listened on
  explicit HostGuard(std::string address) : address_(std::move(address)) {}

  /// @return false, with the refusal in `response`
  bool mayEnter(const httplib::Request& request, httplib::Response& response) const;
  bool isOwnHost(const std::string& host) const;

 private:
  const std::string address_;
  mutable std::mutex mutex_;
  mutable std::vector<std::string> names_;
  mutable Timestamp named_{};
};

}  // namespace slam
