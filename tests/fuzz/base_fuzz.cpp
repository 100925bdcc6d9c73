// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses a base of the table, then what it sends.
#include <cmath>
#include <memory>
#include <vector>

#include "drivers/base/base_facts.hpp"
#include "drivers/base/counted_wheels.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/sim/base/emulated_base.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using fuzz::Bytes;

constexpr Duration kStep = 5ms;
constexpr Duration kPatience = 4s;  // for good bytes to be read behind whatever came: an Arduino may rest for 2 s
constexpr double kCountsPerTurn = 1000.0, kFastest = 100.0;

void check(const BaseFacts& facts, Bytes input) {
  const auto protocol = facts.make({.wheel_radius = 0.03,
                                    .half_track = 0.1,
                                    .counts_per_turn = kCountsPerTurn,
                                    .loop_rate = 30.0,
                                    .may_drive = true});
  Timestamp now{1000s};
  CountedWheels wheels(kCountsPerTurn, facts.counter_bits, kFastest);
  std::size_t readings = 0, counted = 0;
  const BaseProtocol::Take take = [&](const BaseReading& reading) {
    ++readings;
    FUZZ_CHECK(reading.stamp <= now + kStep);
    FUZZ_CHECK(!reading.turn_rate || std::isfinite(*reading.turn_rate));
    FUZZ_CHECK(!reading.battery || (*reading.battery >= 0.0F && *reading.battery < 1e4F));
    if (!reading.counts) return;
    ++counted;
    const WheelAngles angles = wheels.add(reading.stamp, *reading.counts, reading.lifted.value_or(false));
    FUZZ_CHECK(std::isfinite(angles.angles[0]) && std::isfinite(angles.angles[1]));
  };
  const auto pushAll = [&](Bytes bytes) {
    for (const std::uint8_t byte : bytes) {
      const std::uint32_t damage = protocol->damage();
      const std::size_t before = readings;
      protocol->push(byte, now, take);
      FUZZ_CHECK(protocol->damage() >= damage && readings - before <= 64);
    }
  };
  protocol->begin(now);
  for (std::size_t i = 0; i < input.size(); i += 16, now += kStep) {
    FUZZ_CHECK(protocol->question(now).size() <= Outgoing::kMost);
    pushAll(input.subspan(i, std::min<std::size_t>(16, input.size() - i)));
    if (i % 64 == 0 && protocol->takesSpeeds(now))
      FUZZ_CHECK(protocol->speeds({0.1, -0.1}, now).size() <= Outgoing::kMost);
  }
  FUZZ_CHECK(readings <= input.size());
  // Whatever came before: the base itself is read behind it.
  const auto base = sim::makeBase(facts.driver);
  sim::RobotModel robot({}, 1);
  counted = 0;
  for (const Timestamp end = now + kPatience; counted < 3 && now < end; now += kStep) {
    const Outgoing question = protocol->question(now);
    sim::EmulatedBase::Bytes answer;
    base->renew(robot, now);
    base->exchange(question.bytes(), now, answer);
    pushAll(answer);
  }
  FUZZ_CHECK(counted >= 3);
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return -1;
  const auto table = slam::baseTable();
  slam::check(table[data[0] % table.size()], {data + 1, size - 1});
  return 0;
}
