// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>

#include "bus/checked_decode.hpp"
#include "bus/messages.hpp"
#include "bus/refusal.hpp"

namespace slam {

/// A sensor message that has come: as it is, and as a sample; or why it is none.
template <typename Message>
struct Received {
  explicit Received(std::span<const std::uint8_t> data)
      : message(decodeChecked<Message>(data)),
        refusal(message         ? refusalOf(*message)
                : hasType(data) ? Refusal::kSize
                                : Refusal::kType),
        sample(refusal == Refusal::kNone ? fromMessage(*message) : decltype(sample)()) {}

  explicit operator bool() const { return sample.has_value(); }

  std::optional<Message> message;
  Refusal refusal;                          ///< kNone where there is a sample
  decltype(fromMessage(Message{})) sample;  ///< made in place: a scan takes 64 KB of a thread's stack

 private:
  static bool hasType(std::span<const std::uint8_t> data) {
    std::uint64_t fingerprint = 0;  // the highest byte first
    for (std::size_t i = 0; i < sizeof fingerprint && i < data.size(); ++i) fingerprint = fingerprint << 8 | data[i];
    return data.size() >= sizeof fingerprint && fingerprint == static_cast<std::uint64_t>(Message::getHash());
  }
};

}  // namespace slam
