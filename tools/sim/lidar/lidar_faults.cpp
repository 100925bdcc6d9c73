// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_faults.hpp"

#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {

bool LidarFaults::inject(std::string_view kind, double value) {
  using F = LidarFaults;
  constexpr double kMany = 1e6;
  static constexpr FaultKind<F> kKinds[] = {
      {"silent", &F::silent},            // takes nothing, answers nothing, sends nothing; a scan goes on afterwards
      {"health", &F::health, 0.0, 2.0},  // OK, warning, error; with 2 (Protection Stop) it does not scan, reset or not
      {"stall", &F::stalled},            // the motor does not turn: a scan is announced but has no data
      {"lose", &F::lose, 0.0, kMany},    // bytes missing from the next packets, one from each
      {"insert", &F::insert, 0.0, kMany},      // foreign bytes in the next packets, one in each
      {"flip", &F::flip, 0.0, kMany},          // bytes damaged in the next packet
      {"checksum", &F::checksum, 0.0, kMany},  // packets that have a wrong checksum (standard nodes: check bit)
      {"encoder_reset", &F::encoder_reset},    // once: the angle begins at zero again, a capsule has its S bit
      {"pause", &F::pause, 0.0, 600e3},        // [ms] without data; what would have been sampled is missing
      {"turn", &F::turn, 50.0, 60e3},          // [ms] time of a turn from now on: the head all but stands
      // Brown-out: the stream breaks off, the boot banner ends 0.67 s later, then it is idle.
      {"reboot", &F::reboot},
      {"stale", &F::stale, 0.0, 4096.0},  // bytes of an old stream come before the next answer
      {"stuck", &F::stuck},               // every turn from the next on is the one before it, bit by bit
      {"unit",                            // it is an A1 (firmware 1.29), a C1 or an S3 from its next boot on, now
       [](F& f, double to) {
         if (to != 0.0 && to != 1.0 && to != 3.0) return false;
         f.unit = to == 0.0 ? a1Firmware129() : to == 1.0 ? c1() : s3();
         return true;
       },
       0.0, 3.0},
      {"other", &F::other, 0.0, 3.0},  // OtherLidar::Make of the lidar that is in its place; 0 puts it back
      {"echoes", &F::echoes},          // share of the beams that come back: 0 with the cover on or the laser off
      {"dust", &F::dust},              // share of the beams that end at motes within half a metre
      {"wrong", &F::range_factor, 0.1, 10.0},  // factor of all ranges
  };
  return injectFault(kKinds, *this, kind, value);
}

LidarFaults::Fate LidarFaults::nextFate() {
  constexpr double kNearest = 0.16, kFurthest = 0.5;  // [m] of a mote
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Fate fate;
  if (dust > 0.0 && share(random_) < dust) fate.mote = kNearest + (kFurthest - kNearest) * share(random_);
  if (echoes < 1.0) fate.lost = share(random_) >= echoes;
  return fate;
}

void LidarFaults::damage(std::vector<std::uint8_t>& packet, bool capsule) {
  const auto place = [&] { return static_cast<std::ptrdiff_t>(random_() % packet.size()); };
  if (checksum > 0) {
    --checksum;
    packet[capsule ? packet.size() - 1 : 1] ^= 1;
  }
  for (; flip > 0; --flip) packet[static_cast<std::size_t>(place())] ^= static_cast<std::uint8_t>(1 + random_() % 255);
  if (insert > 0) {
    --insert;
    packet.insert(packet.begin() + place(), static_cast<std::uint8_t>(random_()));
  }
  if (lose > 0) {
    --lose;
    packet.erase(packet.begin() + place());
  }
}

}  // namespace slam::sim
