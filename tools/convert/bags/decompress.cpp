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

using Bytes = std::vector<std::uint8_t>;

/// Room for another step, nullptr when out is as large as it may be.
std::uint8_t* grow(Bytes& out, std::size_t used) {
  if (used + kStep > kLargestChunk) return nullptr;
  out.resize(used + kStep);
  return out.data() + used;
}

bool unpackBz2(std::span<const std::uint8_t> data, Bytes& out) {
  bz_stream stream{};
  if (data.size() > std::numeric_limits<unsigned>::max() || BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return false;
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
  stream.avail_in = static_cast<unsigned>(data.size());
  std::size_t used = 0;
  int status = BZ_OK;
  while (status == BZ_OK) {
    std::uint8_t* room = grow(out, used);
    if (room == nullptr) break;
    stream.next_out = reinterpret_cast<char*>(room);
    stream.avail_out = kStep;
    status = BZ2_bzDecompress(&stream);
    const std::size_t made = kStep - stream.avail_out;
    used += made;
    if (status == BZ_OK && made == 0 && stream.avail_in == 0) break;  // cut off
  }
  BZ2_bzDecompressEnd(&stream);
  out.resize(used);
  return status == BZ_STREAM_END;
}

bool unpackLz4(std::span<const std::uint8_t> data, Bytes& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(context,
                                                                                   &LZ4F_freeDecompressionContext);
  std::size_t used = 0, at = 0, wanted = 1;
  while (wanted != 0) {
    std::uint8_t* room = grow(out, used);
    if (room == nullptr) break;
    std::size_t made = kStep, read = data.size() - at;
    wanted = LZ4F_decompress(context, room, &made, data.data() + at, &read, nullptr);
    if (LZ4F_isError(wanted)) break;
    used += made;
    at += read;
    if (made == 0 && read == 0) break;  // cut off
  }
  out.resize(used);
  return wanted == 0;
}

bool unpackZstd(std::span<const std::uint8_t> data, Bytes& out) {
  constexpr int kLargestWindow = 26;  // [bits] as large as a chunk may be
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) return false;
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kLargestWindow);
  ZSTD_inBuffer input{data.data(), data.size(), 0};
  std::size_t used = 0, wanted = 1;
  while (wanted != 0) {
    std::uint8_t* room = grow(out, used);
    if (room == nullptr) break;
    ZSTD_outBuffer output{room, kStep, 0};
    wanted = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(wanted)) break;
    used += output.pos;
    if (output.pos == 0 && input.pos == input.size) break;  // cut off
  }
  out.resize(used);
  return wanted == 0;
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
