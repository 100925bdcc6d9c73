// SPDX-License-Identifier: BSD-3-Clause
// The input is a whole UDP packet, as slamd and slamctl take it from the network.
#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/messages.hpp"
#include "bus/packets.hpp"
#include "bus/udpm/packet_dispatcher.hpp"
#include "fuzz/fuzzing.hpp"

namespace slam {
namespace {

using fuzz::Bytes;

template <typename Message>
void checkMessage(Bytes data) {
  const auto message = decodeChecked<Message>(data);
  if (!message) return;
  const auto again = test::encoded(*message);
  FUZZ_CHECK(std::equal(again.begin(), again.end(), data.begin(), data.end()));
  if constexpr (requires { fromMessage(*message); }) (void)fromMessage(*message);
}

/// Everything that slamd, slamctl and slam-web subscribe to.
class Subscriber {
 public:
  Subscriber() {
    subscribe<scan_t>(channel::kScan);
    subscribe<wheels_t>(channel::kWheels);
    subscribe<imu_t>(channel::kImu);
    subscribe<depth_t>(channel::kDepth);
    subscribe<drive_t>(channel::kDrive);
    subscribe<command_t>(channel::kCommand);
    subscribe<ack_t>(channel::kAck);
    subscribe<health_t>(channel::kHealth);
    subscribe<problems_t>(channel::kProblems);
    subscribe<pose_estimate_t>(channel::kSlamPose);
    subscribe<map_meta_t>(channel::kMapMeta);
    subscribe<map_tile_t>(channel::kMapTile);
  }

  void check(Bytes datagram) {
    datagram_ = datagram;
    const PacketDispatcher::Counts before = dispatcher_.counts();
    const int handed = handed_;
    const Packet packet = dispatcher_.take(datagram);
    const PacketDispatcher::Counts& after = dispatcher_.counts();
    FUZZ_CHECK(after.messages - before.messages == (packet.kind == Packet::kMessage));
    FUZZ_CHECK(after.fragments - before.fragments == (packet.kind == Packet::kFragment));
    FUZZ_CHECK(after.others - before.others == (packet.kind == Packet::kOther));
    FUZZ_CHECK(handed_ - handed <= (packet.kind == Packet::kMessage));
    FUZZ_CHECK(packet.channel.size() <= 63 && packet.channel.find('\0') == std::string_view::npos);
  }

 private:
  template <typename Message>
  void subscribe(const char* channel) {
    dispatcher_.subscribe(channel, [this](Bytes data) {
      ++handed_;
      FUZZ_CHECK(data.size() < datagram_.size());
      FUZZ_CHECK(data.data() + data.size() == datagram_.data() + datagram_.size());
      checkMessage<Message>(data);
    });
  }

  PacketDispatcher dispatcher_;
  Bytes datagram_;
  int handed_ = 0;
};

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static slam::Subscriber subscriber;
  subscriber.check({data, size});
  return 0;
}
