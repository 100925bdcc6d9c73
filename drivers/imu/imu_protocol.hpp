// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>

#include "core/samples.hpp"
#include "firmware_if/outgoing.hpp"
#include "problems/problem.hpp"

namespace slam {

/// What SerialImu needs to know of one make: bytes to samples with stamps, in the unit's axes. A codec has the frames;
/// here is how they make samples, and what is asked. No thread, port or clock; after construction no allocation.
class ImuProtocol {
 public:
  using Take = std::function<void(const ImuSample&)>;
  virtual ~ImuProtocol() = default;

  /// The port was opened: nothing is known of the unit. @param baud [bit/s]
  virtual void begin(int baud) = 0;
  /// A byte has come. @param take gets what it completes
  virtual void push(std::uint8_t byte, Timestamp now, const Take& take) = 0;
  /// What is to be sent to a unit that sends nothing; empty: it is not asked.
  virtual Outgoing wakeUp() { return {}; }
  virtual std::uint32_t frames() const = 0;            ///< good ones, whatever is in them
  virtual std::uint32_t damage() const = 0;            ///< frames that came to nothing
  virtual Problem finding() const { return {}; }       ///< what its samples lack
  virtual const char* identity() const { return ""; }  ///< which of several units it is, once that is known
};

/// Time that so many bytes take on a line. @param baud [bit/s], ten of them for a byte
inline Duration transferTime(std::size_t bytes, int baud) {
  constexpr std::int64_t kBitNanoseconds = 10'000'000'000;
  return baud > 0 ? Duration(kBitNanoseconds * static_cast<std::int64_t>(bytes) / baud) : Duration(0);
}

}  // namespace slam
