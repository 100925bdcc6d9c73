// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdlib>
#include <gtest/gtest.h>
#include <string>
#include <unistd.h>

#include "support/process.hpp"

// The network of the namespace that a test runs in (tests/integration/in_namespace), and what may be in its way.
namespace slam::test {

/// Runs a command of a shell. @return whether it succeeded
inline bool shell(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

/// nftables, which drop what goes to LCM's port while it lives.
class Firewall {
 public:
  static bool isThere() { return shell("nft list ruleset"); }

  /// @param hook "input" or "output"
  explicit Firewall(const std::string& hook) {
    EXPECT_TRUE(shell("nft add table inet lcm && nft add chain inet lcm closed '{ type filter hook " + hook +
                      " priority 0; }' && nft add rule inet lcm closed udp dport 7667 drop"));
  }
  ~Firewall() { EXPECT_TRUE(shell("nft delete table inet lcm")); }
  Firewall(const Firewall&) = delete;
  Firewall& operator=(const Firewall&) = delete;
};

/// Another computer: a namespace of its own, with a cable to this one for each plug().
class OtherMachine {
 public:
  OtherMachine() : holder_({"unshare", "-n", "sleep", "600"}, "/dev/null") {
    const std::string own = "readlink /proc/self/ns/net",
                      its = "readlink /proc/" + std::to_string(holder_.id()) + "/ns/net";
    for (int i = 0; i < 500 && shell("[ \"$(" + own + ")\" = \"$(" + its + ")\" ]"); ++i) usleep(10000);
    EXPECT_TRUE(shell(inside("ip link set lo up")));
  }
  /// A namespace that nobody is in any more keeps its cables for a while, and this side their names.
  ~OtherMachine() { shell("for i in $(ip -br link show type veth | cut -d@ -f1); do ip link del $i; done"); }
  OtherMachine(const OtherMachine&) = delete;
  OtherMachine& operator=(const OtherMachine&) = delete;
  /// The command, there.
  std::string inside(const std::string& command) const {
    return "nsenter -t " + std::to_string(holder_.id()) + " -n " + command;
  }
  /// A network of two: interface `name` on both sides, 10.N.0.1 here and 10.N.0.2 there; without a route to the group.
  void plug(const std::string& name, int number) const {
    const std::string net = "10." + std::to_string(number) + ".0.";
    EXPECT_TRUE(shell("ip link add " + name + " type veth peer name " + name + " netns " +
                      std::to_string(holder_.id()) + " && ip addr add " + net + "1/24 dev " + name +
                      " && ip link set " + name + " up"));
    EXPECT_TRUE(shell(inside("ip addr add " + net + "2/24 dev " + name)));
    EXPECT_TRUE(shell(inside("ip link set " + name + " up")));
  }
  /// On both sides, the group is reached over that interface from now on.
  void route(const std::string& name) const {
    EXPECT_TRUE(shell("ip route replace 224.0.0.0/4 dev " + name));
    EXPECT_TRUE(shell(inside("ip route replace 224.0.0.0/4 dev " + name)));
  }

 private:
  Process holder_;
};

}  // namespace slam::test
