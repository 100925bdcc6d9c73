// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "bus/udpm/udpm_url.hpp"

namespace slam {

/// The way that the kernel would send to a group now; asks by rtnetlink, which answers at once.
class MulticastRoute {
 public:
  explicit MulticastRoute(const UdpmUrl& url);
  ~MulticastRoute();
  MulticastRoute(const MulticastRoute&) = delete;
  MulticastRoute& operator=(const MulticastRoute&) = delete;

  /// @return index of the network interface; 0 where one may not ask, std::nullopt without a route
  std::optional<int> interface() const;

 private:
  const in_addr group_;
  const int socket_;
};

}  // namespace slam
