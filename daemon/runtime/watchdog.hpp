// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/timestamp.hpp"
#include "problems/daemon.hpp"

namespace slam {

/// How long a thread may be silent, which is: not tick.
struct SilenceLimits {
  Duration late;                                     ///< longer: worth a word
  Duration dead;                                     ///< longer: it does not come back by itself
  bool vital = true;                                 ///< there is no pose while it is dead
  const ProblemKind* death = &problem::kThreadDead;  ///< text: the thread's name
};

/// Separates dead threads from late ones by looking at how often they have ticked, and both from those that get no CPU,
/// by what the kernel counts of them: no thread is dead that waits for its turn. Whoever looks may be late itself, or
/// may have been stopped with the whole process: that is no silence of the others.
class Watchdog {
 public:
  /// @param period at which it is looked at all threads
  explicit Watchdog(Duration period) : longest_step_(5 * period) {}

  /// @return its number, counting from 0
  std::size_t add(std::string name, const SilenceLimits& limits);
  /// @param ticks of the thread so far
  /// @param lateness of its latest tick since the last look, as the thread has measured itself
  /// @param starved time since the last look in which it waited for the CPU
  void look(std::size_t thread, std::uint64_t ticks, Duration lateness, Duration starved, Timestamp now);
  /// For a time in which the thread has reason to be silent: nothing of it counts as late.
  void excuse(std::size_t thread) { threads_[thread].excused = true; }

  /// @return whether all vital threads are alive
  bool allAlive() const;
  /// Whether threads have waited for the CPU for so long within the last half minute that they were late.
  bool isOverloaded(Timestamp now) const;
  /// Who is dead, and that the computer was overloaded within the last half minute, or else who was late.
  std::vector<Problem> problems(Timestamp now) const;

  /// A line for the log.
  struct News {
    bool is_error = false;
    std::string thread;  ///< its name
    Problem problem;
  };
  /// What is to be logged since the last call: a death at once, an overload at once and once a minute, lateness when it
  /// is over and once a minute.
  std::vector<News> takeNews(Timestamp now);

 private:
  struct Thread {
    std::string name;
    SilenceLimits limits;
    std::uint64_t ticks = 0;
    Duration silent{0};   // since the last tick ...
    Duration starved{0};  // ... of which it waited for the CPU
    Duration debt{0};     // by how much longer it waited for the CPU lately than it did anything else
    std::optional<Timestamp> looked = {};
    bool excused = false;
    Duration worst{0};                       // lateness that problems() names
    std::optional<Timestamp> was_late = {};  // last
    Duration unlogged{0};                    // the worst lateness since the last line about it
    std::optional<Timestamp> logged = {};
    bool death_logged = false;
    bool isDead() const { return silent - starved > limits.dead; }
  };
  /// The worst wait for the CPU within the last half minute.
  struct Overload {
    std::string thread;
    Duration waited{0};
    std::optional<Timestamp> last = {}, logged = {};
  };
  void noteOverload(const Thread& thread, Duration waited, Timestamp now);
  Problem overload() const;
  static Problem late(const Thread& thread, Duration lateness);
  static Problem dead(const Thread& thread) { return {*thread.limits.death, {}, {thread.name}}; }

  const Duration longest_step_;  // from one look to the next that counts as silence
  std::vector<Thread> threads_;
  Overload overload_;
};

}  // namespace slam
