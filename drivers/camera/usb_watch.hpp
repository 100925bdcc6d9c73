// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <span>

namespace slam {

/// A kind of USB device: one vendor, some products.
struct UsbKind {
  std::uint16_t vendor;
  std::span<const std::uint16_t> products;
};

/// The PrimeSense cameras that OpenNI2 knows, the Xtion Pro Live among them.
inline constexpr std::uint16_t kPrimeSenseProducts[] = {0x0500, 0x0600, 0x0601, 0x0609};
inline constexpr UsbKind kPrimeSense{0x1D27, kPrimeSenseProducts};

/// Looks after a kind of device on the USB. One thread at a time.
class UsbWatch {
 public:
  virtual ~UsbWatch() = default;

  /// Is such a device on the bus? Asks the system, also where there is no udev.
  virtual bool present() = 0;
  /// May this user open the first of them?
  virtual bool permitted() = 0;
  /// Has one been plugged in since the last call? By hot-plug events; never true where there is no udev.
  virtual bool arrived() = 0;
  /// Resets the first such device, as pulling its plug would. Nobody may hold it.
  /// @return whether that was done
  virtual bool reset() = 0;
};

/// Through libusb. Where that does not start, nothing is ever present.
std::unique_ptr<UsbWatch> makeUsbWatch(const UsbKind& kind);

}  // namespace slam
