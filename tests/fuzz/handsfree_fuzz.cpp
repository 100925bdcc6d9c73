// SPDX-License-Identifier: BSD-3-Clause
// The input is what a HandsFree board sends.
#include <algorithm>
#include <vector>

#include "firmware_if/robolink.hpp"
#include "fuzz/fuzzing.hpp"

namespace slam::robolink {
namespace {

using fuzz::Bytes;

/// What a payload says comes back from its own encoding.
template <typename Parse, typename Encode>
void checkPayload(Bytes payload, const Parse& parse, const Encode& encode) {
  const auto value = parse(payload);
  if (!value) return;
  const auto bytes = encode(*value);
  const auto again = parse(bytes);
  FUZZ_CHECK(payload.size() == bytes.size());
  FUZZ_CHECK(again && encode(*again) == bytes);
}

void checkPayloads(Bytes payload) {
  checkPayload(payload, parseCoordinate, encodeCoordinate);
  checkPayload(payload, parseMotorVector, encodeMotorVector);
  checkPayload(payload, parseImu, encodeImu);
  checkPayload(payload, parseSystemInfo, encodeSystemInfo);
}

std::vector<std::uint8_t> encoded(const Frame& frame) {
  std::vector<std::uint8_t> bytes(kMaxFrame);
  bytes.resize(encodeFrame(frame.sender, frame.receiver, static_cast<Command>(frame.command), frame.payload, bytes));
  return bytes;
}

/// Pushes bytes. @return the frames that come out, encoded again
std::vector<std::vector<std::uint8_t>> pushAll(Decoder& decoder, Bytes bytes) {
  std::vector<std::vector<std::uint8_t>> frames;
  for (const std::uint8_t byte : bytes) {
    const DecoderCounters before = decoder.counters();
    for (auto frame = decoder.push(byte); frame; frame = decoder.flush()) {
      FUZZ_CHECK(frame->sender == kSlave && frame->receiver == kMaster);
      checkPayloads(frame->payload);
      frames.push_back(encoded(*frame));
    }
    const DecoderCounters& after = decoder.counters();
    FUZZ_CHECK(after.frames >= before.frames && after.bad_checksums >= before.bad_checksums &&
               after.bad_lengths >= before.bad_lengths && after.foreign_frames >= before.foreign_frames &&
               after.skipped_bytes >= before.skipped_bytes);
  }
  return frames;
}

std::vector<std::uint8_t> goodFrame() {
  const auto payload = encodeMotorVector({-1.5F, 1.25F, 0.0F, 0.0F});  // no byte FF in it
  return encoded({kSlave, kMaster, static_cast<std::uint8_t>(Command::kGetMotorMileage), payload});
}

}  // namespace
}  // namespace slam::robolink

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam::robolink;
  const Bytes input{data, size};
  checkPayloads(input);

  Decoder decoder;
  const auto frames = pushAll(decoder, input);
  FUZZ_CHECK(frames.size() == decoder.counters().frames);
  std::size_t framed = 0;
  auto at = input.begin();
  for (const auto& frame : frames) {  // each lies in the input, behind the one before
    at = std::search(at, input.end(), frame.begin(), frame.end());
    FUZZ_CHECK(at != input.end());
    at += static_cast<std::ptrdiff_t>(frame.size());
    framed += frame.size();
  }
  FUZZ_CHECK(framed + decoder.counters().skipped_bytes <= size);

  // Whatever came before: a false frame that is whole can swallow so many bytes of good ones, and not one more.
  static const std::vector<std::uint8_t> good = goodFrame();
  const std::size_t lost = (kMaxFrame - 1 + good.size() - 1) / good.size(), sent = lost + 3;
  const std::uint32_t foreign = decoder.counters().foreign_frames;
  const bool to_the_end = size % 4 == 0;  // takes longer
  std::size_t received = 0, others = 0;
  for (std::size_t i = 0; i < sent && (to_the_end || received < sent - lost); ++i) {
    for (const auto& frame : pushAll(decoder, good)) ++(frame == good ? received : others);
  }
  FUZZ_CHECK(received >= sent - lost);
  // One that is not whole loses none.
  const bool swallowed = others > 0 || decoder.counters().foreign_frames > foreign;
  FUZZ_CHECK(!to_the_end || swallowed || received >= sent);
  return 0;
}
