// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "bus/udpm/udpm_url.hpp"

namespace slam {

/// The way that the kernel would send to a group now. rtnetlink is asked at the start and again when it has reported a
/// change of routes, rules, addresses or interfaces; it answers at once. Belongs to one thread.
class MulticastRoute {
 public:
  explicit MulticastRoute(const UdpmUrl& url);
  ~MulticastRoute();
  MulticastRoute(const MulticastRoute&) = delete;
  MulticastRoute& operator=(const MulticastRoute&) = delete;

  /// @return index of the network interface; 0 where one may not ask, std::nullopt without a route
  std::optional<int> interface();

 private:
  bool mayHaveChanged() const;
  std::optional<int> ask() const;

  const in_addr group_;
  const int questions_, changes_;  // sockets; -1: not permitted
  std::optional<int> interface_;
};

}  // namespace slam
