// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slam {

/// An eventfd: one side notifies without waiting, the other polls the descriptor.
class Wakeup {
 public:
  /// @throws std::system_error when the process has no descriptor left
  Wakeup();
  ~Wakeup();
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  void notify();
  void clear();
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace slam
