// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace slam::can {

/// What the drives of the wheels send and take.
enum class Protocol : std::uint8_t { kOdrive, kVesc };

/// One classic CAN frame.
struct Frame {
  std::uint32_t id = 0;   ///< 11 or 29 bits; of an error frame: its classes
  std::uint8_t size = 0;  ///< [bytes] 0..8
  bool extended = false;  ///< 29-bit identifier
  bool remote = false;    ///< asks for data, has none
  bool error = false;     ///< made by the own controller, never on the wire
  std::array<std::uint8_t, 8> data{};

  std::span<const std::uint8_t> payload() const { return {data.data(), size}; }
  friend bool operator==(const Frame&, const Frame&) = default;
};

/// Is it a data frame with this 11-bit identifier and so many bytes?
inline bool isData(const Frame& frame, std::uint32_t id, std::size_t size) {
  return frame.id == id && frame.size == size && !frame.extended && !frame.remote && !frame.error;
}

}  // namespace slam::can
