// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses what is read, then what a lidar with a protocol of text sends.
#include <string>
#include <vector>

#include "drivers/lidar/codec/cola_codec.hpp"
#include "drivers/lidar/codec/scip_codec.hpp"
#include "drivers/lidar/cola/cola_decoder.hpp"
#include "drivers/lidar/scip/scip_decoder.hpp"
#include "fuzz/fuzzing.hpp"
#include "tools/sim/lidar/cola_emulator.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"

namespace slam {
namespace {

using fuzz::Bytes;

constexpr int kTurnQ6 = 360 * 64;

std::string textOf(Bytes input) { return {input.begin(), input.end()}; }

std::size_t pushAll(LidarDecoder& decoder, Bytes bytes) {
  std::size_t count = 0;
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : bytes) {
    const std::int64_t rejects = decoder.rejects();
    nodes.clear();
    decoder.push(byte, nodes);
    FUZZ_CHECK(nodes.size() <= decoder.mostNodes() && decoder.lost() >= 0 && decoder.rejects() >= rejects);
    FUZZ_CHECK(decoder.endsTurn() == !nodes.empty());
    for (const TimedNode& timed : nodes) {
      FUZZ_CHECK(timed.node.angle_q6 < kTurnQ6 && timed.node.distance_q2 <= 4U << 18);
      FUZZ_CHECK(timed.age >= 0.0 && timed.age < 10.0);
    }
    count += nodes.size();
  }
  return count;
}

/// Whatever came before: of good turns behind it, all but two are read.
void checkDecoder(LidarDecoder& decoder, sim::EmulatedLidar& unit, const std::vector<std::uint8_t>& begin,
                  Bytes input) {
  FUZZ_CHECK(pushAll(decoder, input) <= input.size());
  Timestamp now{std::chrono::seconds(1)};
  std::vector<std::uint8_t> bytes;
  unit.receive(begin, now, bytes);
  bytes.clear();
  constexpr std::size_t kTurns = 4;
  for (std::size_t turns = 0; turns < kTurns; now += std::chrono::milliseconds(5)) {
    std::vector<std::uint8_t> turn;
    unit.stream(now, turn);
    turns += !turn.empty();
    bytes.insert(bytes.end(), turn.begin(), turn.end());
  }
  FUZZ_CHECK(pushAll(decoder, bytes) >= (kTurns - 2) * decoder.mostNodes());
}

double room(Timestamp, double) { return 1.5; }

void checkScip(Bytes input) {
  const sim::ScipModel& model = sim::scipModels()[0];
  const scip::Parameters unit{.model = model.product,
                              .steps_per_turn = model.steps_per_turn,
                              .first = model.first,
                              .last = model.last,
                              .front = model.front,
                              .least_mm = model.least_mm,
                              .most_mm = model.most_mm,
                              .turns_per_minute = model.turns_per_minute};
  const std::string command = scip::scanCommand(unit);
  ScipDecoder decoder(unit, command, 1e-6);
  sim::ScipEmulator lidar(room, model);
  const std::string line = command + "\n";
  checkDecoder(decoder, lidar, std::vector<std::uint8_t>(line.begin(), line.end()), input);
}

void checkScipAnswers(Bytes input) {
  const std::string text = textOf(input);
  std::size_t size = 0;
  const auto answer = scip::findAnswer(text, "PP", size);
  if (!answer) return;
  FUZZ_CHECK(size <= text.size() && (answer->status.empty() || answer->status.size() == 2));
  const auto unit = scip::parseParameters(*answer);
  if (!unit) return;
  FUZZ_CHECK(unit->steps() > 1 && unit->steps() <= unit->steps_per_turn && unit->turnTime() > 0.0);
  for (int step = unit->first; step <= unit->last; ++step) FUZZ_CHECK(unit->angleQ6(step) < kTurnQ6);
  FUZZ_CHECK(scip::scanCommand(*unit).size() == 15);
}

const std::string& colaExample() {
  static const std::string text = [] {
    sim::ColaEmulator lidar(room, sim::colaModels()[0]);
    std::vector<std::uint8_t> out;
    const std::string request = cola::telegram("sRN LMDscandata");
    lidar.receive(std::vector<std::uint8_t>(request.begin(), request.end()), Timestamp{std::chrono::seconds(1)}, out);
    return std::string(out.begin() + 1, out.end() - 1);
  }();
  return text;
}

void checkCola(Bytes input) {
  ColaDecoder decoder(*cola::parseScan(colaExample()), 0.0);
  sim::ColaEmulator lidar(room, sim::colaModels()[0]);
  const std::string request = cola::telegram("sEN LMDscandata 1");
  checkDecoder(decoder, lidar, std::vector<std::uint8_t>(request.begin(), request.end()), input);
}

void checkColaScan(Bytes input) {
  const std::string text = textOf(input);
  std::size_t size = 0;
  if (cola::findTelegram(text, "sRA DeviceIdent ", "sFA", size)) FUZZ_CHECK(size <= text.size());
  const auto scan = cola::parseScan(text);
  if (!scan) return;
  FUZZ_CHECK(scan->beams > 0 && scan->per_turn > 0 && scan->turn_time > 0.0 && scan->scale > 0.0);
  FUZZ_CHECK(scan->values.size() <= text.size() && scan->stepTime() > 0.0);
  for (int beam = 0; beam < scan->beams; ++beam) FUZZ_CHECK(scan->angleQ6(beam) < kTurnQ6);
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return -1;
  constexpr void (*kChecks[])(slam::fuzz::Bytes) = {slam::checkScip, slam::checkScipAnswers, slam::checkCola,
                                                    slam::checkColaScan};
  kChecks[data[0] % std::size(kChecks)]({data + 1, size - 1});
  return 0;
}
