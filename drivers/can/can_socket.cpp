// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_socket.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace slam {
namespace {

constexpr std::size_t kMaxFilters = 32;
constexpr Duration kOldest = std::chrono::seconds(1);  // no frame waits longer in a socket that is read

// What tells the state of controller and bus. Errors of single frames (CAN_ERR_BUSERROR) can come by the thousand, and
// the controllers that send them set CAN_ERR_PROT, CAN_ERR_ACK or CAN_ERR_LOSTARB beside: one bit passes the filter.
constexpr can_err_mask_t kErrors = CAN_ERR_TX_TIMEOUT | CAN_ERR_CRTL | CAN_ERR_TRX | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED;

Duration toDuration(const timespec& t) { return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec); }

can_frame toKernel(const can::Frame& frame) {
  can_frame raw{};
  raw.can_id = frame.id & (frame.extended ? CAN_EFF_MASK : frame.error ? CAN_ERR_MASK : CAN_SFF_MASK);
  raw.can_id |= (frame.extended ? CAN_EFF_FLAG : 0) | (frame.remote ? CAN_RTR_FLAG : 0);
  raw.can_id |= frame.error ? CAN_ERR_FLAG : 0;
  raw.len = std::min<std::uint8_t>(frame.size, CAN_MAX_DLEN);
  std::copy(frame.data.begin(), frame.data.end(), raw.data);
  return raw;
}

can::Frame fromKernel(const can_frame& raw) {
  can::Frame frame;
  frame.error = (raw.can_id & CAN_ERR_FLAG) != 0;
  frame.extended = !frame.error && (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = !frame.error && (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.id = raw.can_id & (frame.error ? CAN_ERR_MASK : frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.size = std::min<std::uint8_t>(raw.len, CAN_MAX_DLEN);
  std::copy(std::begin(raw.data), std::end(raw.data), frame.data.begin());
  return frame;
}

class SocketCanPort : public CanPort {
 public:
  explicit SocketCanPort(Timestamp (*now)()) : now_(now) {}
  ~SocketCanPort() override { SocketCanPort::close(); }
  SocketCanPort(const SocketCanPort&) = delete;
  SocketCanPort& operator=(const SocketCanPort&) = delete;

  int open(const std::string& interface, std::span<const std::uint32_t> ids) override;
  void close() override;
  int receive(StampedCanFrame& out) override;
  int send(const can::Frame& frame) override;
  int pendingError() override;
  int interfaceError() override;

 private:
  int closeWith(int error) {
    close();
    return error;
  }
  Timestamp stampOf(const msghdr& message) const;

  Timestamp (*now_)();
  int socket_ = -1;
  int index_ = 0;      // of the interface bound to
  ifreq interface_{};  // its name, for questions about it
};

int SocketCanPort::open(const std::string& interface, std::span<const std::uint32_t> ids) {
  close();
  if (interface.size() >= IFNAMSIZ || ids.size() > kMaxFilters) return ENAMETOOLONG;
  socket_ = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (socket_ < 0) return errno;
  interface_ = {};
  interface.copy(interface_.ifr_name, IFNAMSIZ - 1);
  if (ioctl(socket_, SIOCGIFINDEX, &interface_) != 0) return closeWith(errno);
  index_ = interface_.ifr_ifindex;

  std::array<can_filter, kMaxFilters> filters{};
  static_assert(kExtended == CAN_EFF_FLAG);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const canid_t bits = (ids[i] & kExtended) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK;
    filters[i] = {ids[i], bits | CAN_EFF_FLAG | CAN_RTR_FLAG};
  }
  const auto set = [this](int level, int option, const void* value, std::size_t size) {
    return setsockopt(socket_, level, option, value, static_cast<socklen_t>(size)) == 0;
  };
  const int off = 0, stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index_;
  const bool bound = set(SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), ids.size() * sizeof(can_filter)) &&
                     set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &kErrors, sizeof kErrors) &&
                     set(SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &off, sizeof off) &&
                     set(SOL_SOCKET, SO_TIMESTAMPING, &stamps, sizeof stamps) &&
                     bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  return bound ? 0 : closeWith(errno);
}

void SocketCanPort::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

int SocketCanPort::receive(StampedCanFrame& out) {
  can_frame raw{};
  iovec piece{&raw, sizeof raw};
  alignas(cmsghdr) std::array<char, 256> control;
  msghdr message{};
  for (;;) {
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t n = recvmsg(socket_, &message, MSG_DONTWAIT);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n != static_cast<ssize_t>(CAN_MTU) || (message.msg_flags & MSG_CONFIRM) != 0) continue;
    out = {fromKernel(raw), stampOf(message)};
    return 0;
  }
}

Timestamp SocketCanPort::stampOf(const msghdr& message) const {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  const Timestamp now = now_();
  for (const cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr;
       part = CMSG_NXTHDR(const_cast<msghdr*>(&message), const_cast<cmsghdr*>(part))) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPING) continue;
    timespec software{};
    std::memcpy(&software, CMSG_DATA(part), sizeof software);  // the first of three
    return stampFromWallClock(toDuration(software), toDuration(wall), now);
  }
  return now;
}

int SocketCanPort::send(const can::Frame& frame) {
  const can_frame raw = toKernel(frame);
  const ssize_t n = ::send(socket_, &raw, sizeof raw, MSG_DONTWAIT);
  return n == static_cast<ssize_t>(sizeof raw) ? 0 : n < 0 ? errno : EIO;
}

int SocketCanPort::pendingError() {
  int error = 0;
  socklen_t size = sizeof error;
  return getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

int SocketCanPort::interfaceError() {
  // Asked by name: an interface that was made anew has the same name and another index.
  if (ioctl(socket_, SIOCGIFINDEX, &interface_) != 0 || interface_.ifr_ifindex != index_) return ENODEV;
  if (ioctl(socket_, SIOCGIFFLAGS, &interface_) != 0) return ENODEV;
  return (interface_.ifr_flags & IFF_UP) != 0 ? 0 : ENETDOWN;
}

}  // namespace

std::unique_ptr<CanPort> makeSocketCanPort(Timestamp (*now)()) { return std::make_unique<SocketCanPort>(now); }

Timestamp stampFromWallClock(Duration wall_stamp, Duration wall_now, Timestamp now) {
  const Duration age = wall_now - wall_stamp;
  return age < Duration(0) || age > kOldest ? now : now - age;
}

}  // namespace slam
