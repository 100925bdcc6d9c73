// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/usb_watch.hpp"

#include <algorithm>
#include <libusb-1.0/libusb.h>
#include <sys/time.h>
#include <utility>
#include <vector>

namespace slam {
namespace {

class LibusbWatch : public UsbWatch {
 public:
  explicit LibusbWatch(const UsbKind& kind)
      : vendor_(kind.vendor), products_(kind.products.begin(), kind.products.end()) {
    if (libusb_init(&context_) != LIBUSB_SUCCESS) {
      context_ = nullptr;
      return;
    }
    if (!libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG)) return;
    libusb_hotplug_register_callback(context_, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, LIBUSB_HOTPLUG_NO_FLAGS, vendor_,
                                     LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, &LibusbWatch::onArrival, this,
                                     nullptr);
  }
  ~LibusbWatch() override {
    if (context_ != nullptr) libusb_exit(context_);
  }

  bool present() override {
    bool found = false;
    forEach([&](libusb_device*) { found = true; });
    return found;
  }

  bool permitted() override {
    bool opened = false;
    forEach([&](libusb_device* device) {
      libusb_device_handle* handle = nullptr;
      if (libusb_open(device, &handle) != LIBUSB_SUCCESS) return;
      opened = true;
      libusb_close(handle);
    });
    return opened;
  }

  bool arrived() override {
    if (context_ == nullptr) return false;
    timeval at_once{0, 0};
    libusb_handle_events_timeout_completed(context_, &at_once, nullptr);
    return std::exchange(arrived_, false);
  }

  bool reset() override {
    bool done = false;
    forEach([&](libusb_device* device) {
      libusb_device_handle* handle = nullptr;
      if (libusb_open(device, &handle) != LIBUSB_SUCCESS) return;
      const int result = libusb_reset_device(handle);
      // Not found means that it came back as a new device: that is what was wanted.
      done = result == LIBUSB_SUCCESS || result == LIBUSB_ERROR_NOT_FOUND;
      libusb_close(handle);
    });
    return done;
  }

 private:
  bool matches(libusb_device* device) const {
    libusb_device_descriptor descriptor{};
    return libusb_get_device_descriptor(device, &descriptor) == LIBUSB_SUCCESS && descriptor.idVendor == vendor_ &&
           std::find(products_.begin(), products_.end(), descriptor.idProduct) != products_.end();
  }

  template <typename Visit>
  void forEach(Visit&& visit) {
    if (context_ == nullptr) return;
    libusb_device** list = nullptr;
    const ssize_t count = libusb_get_device_list(context_, &list);
    for (ssize_t i = 0; i < count; ++i) {
      if (matches(list[i])) visit(list[i]);
    }
    if (count >= 0) libusb_free_device_list(list, 1);
  }

  // Within libusb's event handling: no transfer, only a flag.
  static int LIBUSB_CALL onArrival(libusb_context*, libusb_device* device, libusb_hotplug_event, void* self) {
    auto* watch = static_cast<LibusbWatch*>(self);
    watch->arrived_ |= watch->matches(device);
    return 0;  // go on
  }

  libusb_context* context_ = nullptr;
  std::uint16_t vendor_;
  std::vector<std::uint16_t> products_;
  bool arrived_ = false;
};

}  // namespace

std::unique_ptr<UsbWatch> makeUsbWatch(const UsbKind& kind) { return std::make_unique<LibusbWatch>(kind); }

}  // namespace slam
