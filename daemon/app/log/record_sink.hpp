// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <exception>
#include <string_view>

#include "problems/daemon.hpp"

namespace slam {

/// Where a Recorder writes to. All is called by the Recorder's thread.
class RecordSink {
 public:
  virtual ~RecordSink() = default;

  /// Ten times a second, whatever the disk does. Must not throw.
  virtual void tend() {}
  /// Opens what is not open, and writes whole records, if there are any: all of them, or none and an exception.
  /// @param utime [us] of the first one
  virtual void write(std::string_view records, std::int64_t utime) = 0;
  /// Behind the last write(). @throws std::exception when something written before is lost
  virtual void finish() {}
  /// @param error that was thrown last
  virtual Problem problemOf(const std::exception& error) const = 0;
};

}  // namespace slam
