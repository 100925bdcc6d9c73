// SPDX-License-Identifier: BSD-3-Clause
// The input is what a stand-alone IMU sends; each protocol of the table takes it, and so do HandsFree's two decoders.
#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/plausibility.hpp"
#include "drivers/imu/codec/witmotion_frames.hpp"
#include "drivers/imu/imu_facts.hpp"
#include "firmware_if/hfi_imu.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/sim/imu/emulated_imu.hpp"

namespace slam::hfi {
namespace {

using fuzz::Bytes;
using Frame = std::vector<std::uint8_t>;

template <typename Array>
Frame frameOf(const Array& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// A frame's values, encoded again: a frame of the A9 keeps eight bytes of unknown meaning.
void checkA9(Bytes frame) {
  const auto motion = parseA9Motion(frame);
  if (!motion) return;  // attitude, or not finite
  FUZZ_CHECK(std::isfinite(motion->gyro[0]) && std::isfinite(motion->accel[2]) && std::isfinite(motion->magnetic[1]));
  const Frame again = frameOf(encodeA9(*motion));
  FUZZ_CHECK(again.size() == frame.size());
  FUZZ_CHECK(std::equal(frame.begin() + 11, frame.end() - 2, again.begin() + 11));
}

void checkB6(Bytes frame) {
  const Frame again = frameOf(witmotion::encode(witmotion::parse(frame)));
  FUZZ_CHECK(std::equal(frame.begin(), frame.end(), again.begin(), again.end()));
}

template <typename Decoder, typename Check>
void checkDecoder(Bytes input, const Frame& good, std::size_t longest, Check&& check) {
  Decoder decoder;
  std::size_t framed = 0;
  for (const std::uint8_t byte : input) {
    const std::uint32_t damaged = decoder.damaged(), skipped = decoder.skipped();
    decoder.push(byte, [&](Bytes frame) {
      check(frame);
      framed += frame.size();
    });
    FUZZ_CHECK(decoder.damaged() >= damaged && decoder.skipped() >= skipped);
  }
  const std::size_t lost_bytes = decoder.damaged() + decoder.skipped();
  FUZZ_CHECK(framed + lost_bytes <= input.size());
  FUZZ_CHECK(input.size() - framed - lost_bytes < longest);  // held back

  // Whatever came before: a false frame that is whole can swallow so many bytes of good ones, and not one more.
  const std::size_t lost = (longest - 1 + good.size() - 1) / good.size(), sent = lost + 3;
  std::size_t received = 0, others = 0;
  for (std::size_t i = 0; i < sent; ++i) {
    for (const std::uint8_t byte : good)
      decoder.push(byte, [&](Bytes frame) {
        ++(std::equal(frame.begin(), frame.end(), good.begin(), good.end()) ? received : others);
      });
  }
  FUZZ_CHECK(received >= sent - lost);
  FUZZ_CHECK(others > 0 || received >= sent);  // one that is not whole loses none
}

}  // namespace
}  // namespace slam::hfi

namespace slam {
namespace {

using namespace std::chrono_literals;

void checkProtocol(const ImuFacts& facts, fuzz::Bytes input) {
  const auto protocol = facts.make();
  protocol->begin(facts.bauds.front());
  Timestamp now{1000s};
  std::size_t samples = 0, plausible = 0;
  const ImuProtocol::Take take = [&](const ImuSample& sample) {
    ++samples;
    plausible += isPlausible(sample) ? 1 : 0;
    FUZZ_CHECK(sample.stamp <= now);
  };
  const auto push = [&](std::uint8_t byte) {
    const std::uint32_t damage = protocol->damage(), frames = protocol->frames();
    protocol->push(byte, now, take);
    FUZZ_CHECK(protocol->damage() >= damage && protocol->frames() >= frames);
  };
  for (std::size_t i = 0; i < input.size(); ++i) {
    push(input[i]);
    if (i % 16 == 15) now += 1ms;
  }
  FUZZ_CHECK(samples <= input.size());
  FUZZ_CHECK(protocol->wakeUp().size() <= Outgoing::kMost);
  // Whatever came before: the unit itself is read behind it. HandsFree's framing is chosen once for each opening.
  if (std::string_view(facts.driver) == "hfi") protocol->begin(facts.bauds.front());
  const auto unit = sim::makeImu(facts.driver);
  plausible = 0;
  for (int i = 0; i < 400 && plausible < 3; ++i) {
    now += sim::EmulatedImu::kPeriod;
    sim::EmulatedImu::Bytes bytes;
    unit->sample({0.0, 0.0, 0.5}, {0.0, 0.0, 9.81}, bytes);
    for (const std::uint8_t byte : bytes) push(byte);
  }
  FUZZ_CHECK(plausible >= 3);
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam::hfi;
  static const Frame motion =
      frameOf(encodeA9(A9Motion{{0.5F, -0.25F, 1.5F}, {0.0F, 0.125F, -1.0F}, {1.0F, 2.0F, 3.0F}}));
  static const Frame attitude = frameOf(encodeA9(A9Attitude{1.0F, -2.0F, 90.0F}));
  static const Frame gyro = frameOf(slam::witmotion::encode({slam::witmotion::Type::kTurnRate, {100, -200, 300, 0}}));
  const Bytes input{data, size};
  checkDecoder<A9Decoder>(input, size % 2 == 0 ? motion : attitude, kA9MaxFrame, checkA9);
  checkDecoder<slam::witmotion::Decoder>(input, gyro, slam::witmotion::kFrameSize, checkB6);
  for (const slam::ImuFacts& facts : slam::imuTable()) slam::checkProtocol(facts, input);
  return 0;
}
