// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/imu/faulty_imu.hpp"

#include <algorithm>

#include "tools/faults/fault_kinds.hpp"

namespace slam::sim {

bool ImuFaults::inject(std::string_view kind, double value) {
  using F = ImuFaults;
  constexpr double kMany = 1e6;
  static constexpr FaultKind<F> kKinds[] = {
      {"silent", &F::silent},                  // sends nothing
      {"garbage", &F::garbage},                // sends random bytes, as many as otherwise
      {"checksum", &F::checksum, 0.0, kMany},  // so many frames have a wrong checksum
      {"lose", &F::lose, 0.0, kMany},          // bytes missing from the next frames, one from each
      {"insert", &F::insert, 0.0, kMany},      // foreign bytes in the next frames, one in each
      {"flip", &F::flip, 0.0, kMany},          // bytes damaged in the next frame
      {"stuck", &F::stuck},                    // sends the same values for ever
      {"slow", &F::slow, 1.0, 1000.0},         // only each n-th sample comes
      {"no_accel", &F::no_accel},              // its acceleration is switched off, where it can be
      {"no_rate", &F::no_rate},                // its turn rate is switched off, where it can be
      {"absurd", &F::absurd},                  // turn rates that no sensor measures, of either sign
      {"wrong", &F::factor, -1e9, 1e9},        // turn rates are multiplied by it
  };
  return injectFault(kKinds, *this, kind, value);
}

void FaultyImu::send(std::span<const std::uint8_t> frame, Bytes& out) {
  if (faults_.silent) return;
  Bytes bytes(frame.begin(), frame.end());
  const auto place = [&] { return static_cast<std::ptrdiff_t>(random_() % bytes.size()); };
  if (faults_.checksum > 0) --faults_.checksum, ++bytes.back();
  for (; faults_.flip > 0; --faults_.flip)
    bytes[static_cast<std::size_t>(place())] ^= static_cast<std::uint8_t>(1 + random_() % 255);
  if (faults_.insert > 0) --faults_.insert, bytes.insert(bytes.begin() + place(), static_cast<std::uint8_t>(random_()));
  if (faults_.lose > 0) --faults_.lose, bytes.erase(bytes.begin() + place());
  if (faults_.garbage)
    std::generate(bytes.begin(), bytes.end(), [this] { return static_cast<std::uint8_t>(random_()); });
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void FaultyImu::sample(const Vector& gyro, const Vector& accel, Bytes& out) {
  constexpr double kAbsurd = 1e9;  // [rad/s]
  if (!faults_.stuck) {
    for (std::size_t i = 0; i < 3; ++i) gyro_[i] = faults_.factor * gyro[i];
    if (faults_.absurd) gyro_.fill(kAbsurd * (random_() % 2 == 0 ? 1.0 : -0.7));
    accel_ = accel;
  }
  renew(faults_.stuck ? Vector{} : gyro_);
  if (++samples_ % faults_.slow == 0) encode(gyro_, accel_, out);
}

}  // namespace slam::sim
