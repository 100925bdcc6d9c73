// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/usb_watch.hpp"

#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "build_paths.hpp"

namespace slam::usb_watch_test {
namespace {

// Of no maker: what is asked of the real bus here must be true on every machine.
constexpr std::uint16_t kProducts[] = {0x0001, 0x0002};
constexpr UsbKind kNobody{0xFFFF, kProducts};

TEST(UsbWatch, ReportsThatADeviceNobodyMakesIsNotThere) {
  const auto usb = makeUsbWatch(kNobody);
  EXPECT_FALSE(usb->present());
  EXPECT_FALSE(usb->permitted());
  EXPECT_FALSE(usb->arrived());
  EXPECT_FALSE(usb->reset());
}

TEST(UsbWatch, TheUdevRulesNameTheCamerasThatAreWatched) {
  std::ifstream in(SLAMD_SOURCE_DIR "/systemd/70-slamd.rules");
  const std::string rules{std::istreambuf_iterator<char>(in), {}};
  std::string products;
  for (const std::uint16_t product : kPrimeSense.products) {
    char id[8];
    std::snprintf(id, sizeof id, "|%04x", product);
    products += id;
  }
  EXPECT_NE(rules.find("ATTR{idVendor}==\"1d27\", ATTR{idProduct}==\"" + products.substr(1) + "\""), std::string::npos)
      << products;
}

TEST(UsbWatch, CanBeAskedForLong) {
  const auto usb = makeUsbWatch(kNobody);
  for (int i = 0; i < 200; ++i) {
    ASSERT_FALSE(usb->present());
    ASSERT_FALSE(usb->arrived());
  }
}

}  // namespace
}  // namespace slam::usb_watch_test
