// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/decompress.hpp"

#include <algorithm>
#include <bzlib.h>
#include <limits>
#include <lz4frame.h>
#include <memory>
#include <zstd.h>

namespace slam {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 16;  // [bytes] that out grows by

using Unpacked = std::vector<std::uint8_t>;

/// What a decoder made of its input in one step.
struct Step {
  std::size_t made;   // [bytes]
  bool ended, stuck;  // the data is whole; it is damaged, or cut off
};

/// Calls step(room) for kStep bytes of room each until the data ends. @return false: it is damaged, cut off or too
/// large
template <typename Decode>
bool unpack(Unpacked& out, const Decode& decode) {
  Step step{0, false, false};
  std::size_t used = 0;
  while (!step.ended && !step.stuck && used + kStep <= kLargestChunk) {
    out.resize(used + kStep);
    step = decode(out.data() + used);
    used += step.made;
  }
  out.resize(used);
  return step.ended;
}

bool unpackBz2(std::span<const std::uint8_t> data, Unpacked& out) {
  bz_stream stream{};
  if (data.size() > std::numeric_limits<unsigned>::max() || BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return false;
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> owner(&stream, &BZ2_bzDecompressEnd);
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
  stream.avail_in = static_cast<unsigned>(data.size());
  return unpack(out, [&](std::uint8_t* room) {
    stream.next_out = reinterpret_cast<char*>(room);
    stream.avail_out = kStep;
    const int status = BZ2_bzDecompress(&stream);
    const std::size_t made = kStep - stream.avail_out;
    return Step{made, status == BZ_STREAM_END, status != BZ_OK || (made == 0 && stream.avail_in == 0)};
  });
}

bool unpackLz4(std::span<const std::uint8_t> data, Unpacked& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(context,
                                                                                   &LZ4F_freeDecompressionContext);
  return unpack(out, [&](std::uint8_t* room) {
    std::size_t made = kStep, read = data.size();
    const std::size_t wanted = LZ4F_decompress(context, room, &made, data.data(), &read, nullptr);
    if (LZ4F_isError(wanted)) return Step{0, false, true};
    data = data.subspan(read);
    return Step{made, wanted == 0, made == 0 && read == 0};
  });
}

bool unpackZstd(std::span<const std::uint8_t> data, Unpacked& out) {
  constexpr int kLargestWindow = 26;  // [bits] as large as a chunk may be
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) return false;
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindow);
  ZSTD_inBuffer input{data.data(), data.size(), 0};
  return unpack(out, [&](std::uint8_t* room) {
    ZSTD_outBuffer output{room, kStep, 0};
    const std::size_t wanted = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(wanted)) return Step{0, false, true};
    return Step{output.pos, wanted == 0, output.pos == 0 && input.pos == input.size};
  });
}

}  // namespace

bool decompress(std::string_view compression, std::span<const std::uint8_t> data, std::vector<std::uint8_t>& out) {
  out.clear();
  if (compression == "bz2") return unpackBz2(data, out);
  if (compression == "lz4") return unpackLz4(data, out);
  if (compression == "zstd") return unpackZstd(data, out);
  if (!compression.empty() && compression != "none") return false;
  const std::size_t size = std::min(data.size(), kLargestChunk);
  out.assign(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(size));
  return size == data.size();
}

}  // namespace slam
