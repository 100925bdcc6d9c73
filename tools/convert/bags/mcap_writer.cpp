// SPDX-License-Identifier: BSD-3-Clause
// Format: mcap.dev/spec. Numbers are little-endian; texts, lists and records have their size before them.
#include "tools/convert/bags/mcap_writer.hpp"

#include <algorithm>
#include <limits>
#include <zlib.h>
#include <zstd.h>

#include "tools/convert/bags/mcap.hpp"

namespace slam {
namespace {

constexpr std::size_t kFullChunk = 1U << 20;  // [bytes] unpacked, from which a chunk is full

template <typename Integer>
std::string number(Integer value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
  return bytes;
}

std::string sized(std::string_view bytes) {
  return number(static_cast<std::uint32_t>(bytes.size())) + std::string(bytes);
}

std::string record(mcap::Op op, const std::string& content) {
  return static_cast<char>(op) + number(static_cast<std::uint64_t>(content.size())) + content;
}

std::uint64_t nanoseconds(std::int64_t utime) {
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max() / 1000;
  return static_cast<std::uint64_t>(std::clamp<std::int64_t>(utime, 0, kLast)) * 1000;
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& file, Messages encoding) : file_(file), encoding_(encoding) {
  const char* const profile = encoding_ == Messages::kRos2 ? "ros2" : "";
  put(std::string(mcap::kMagic) + record(mcap::kHeader, sized(profile) + sized("slamd")));
}

void McapWriter::put(const std::string& bytes) {
  file_.write(bytes);
  at_ += bytes.size();
}

std::uint16_t McapWriter::addChannel(const std::string& topic, const std::string& schema,
                                     const std::string& description) {
  const bool ros2 = encoding_ == Messages::kRos2;
  Channel channel;
  const auto [at, added] = schemas_.emplace(schema, static_cast<std::uint16_t>(schemas_.size() + 1));
  if (added) {
    channel.schema_record = record(mcap::kSchema, number(at->second) + sized(schema) +
                                                      sized(ros2 ? "ros2msg" : "jsonschema") + sized(description));
  }
  const auto id = static_cast<std::uint16_t>(channels_.size());
  channel.channel_record =
      record(mcap::kChannel, number(id) + number(at->second) + sized(topic) + sized(ros2 ? "cdr" : "json") + sized(""));
  put(channel.schema_record + channel.channel_record);
  channels_.push_back(std::move(channel));
  return id;
}

void McapWriter::write(std::uint16_t channel, std::int64_t received, std::int64_t utime, std::string_view message) {
  const std::uint64_t time = nanoseconds(received);
  Channel& of = channels_.at(channel);
  of.in_chunk.emplace_back(time, chunk_.size());
  chunk_ += record(mcap::kMessage, number(channel) + number(static_cast<std::uint32_t>(of.messages++)) + number(time) +
                                       number(nanoseconds(utime)) + std::string(message));
  ++messages_;
  chunk_first_ = std::min(chunk_first_, time);
  chunk_last_ = std::max(chunk_last_, time);
  if (chunk_.size() >= kFullChunk) endChunk();
}

void McapWriter::endChunk() {
  if (chunk_.empty()) return;
  std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), 3));
  const auto crc = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(chunk_.data()), static_cast<uInt>(chunk_.size())));
  ChunkIndex index{chunk_first_, chunk_last_, at_, 0, 0, packed.size(), chunk_.size(), {}};
  put(record(mcap::kChunk, number(chunk_first_) + number(chunk_last_) + number(std::uint64_t{chunk_.size()}) +
                               number(crc) + sized("zstd") + number(std::uint64_t{packed.size()}) + packed));
  index.size = at_ - index.start;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].in_chunk.empty()) continue;
    std::string entries;
    for (const auto& [time, offset] : channels_[i].in_chunk) entries += number(time) + number(offset);
    channels_[i].in_chunk.clear();
    const auto id = static_cast<std::uint16_t>(i);
    index.indexes.emplace(id, at_);
    put(record(mcap::kMessageIndex, number(id) + sized(entries)));
  }
  index.indexes_size = at_ - index.start - index.size;
  chunks_.push_back(std::move(index));
  first_ = std::min(first_, chunk_first_);
  last_ = std::max(last_, chunk_last_);
  chunk_.clear();
  chunk_first_ = ~std::uint64_t{0};
  chunk_last_ = 0;
}

void McapWriter::close() {
  endChunk();
  put(record(mcap::kDataEnd, number(std::uint32_t{0})));  // 0: without a sum
  const std::uint64_t summary = at_;
  std::string offsets;
  const auto group = [&](mcap::Op op, const std::string& records) {
    if (records.empty()) return;
    offsets +=
        record(mcap::kSummaryOffset, static_cast<char>(op) + number(at_) + number(std::uint64_t{records.size()}));
    put(records);
  };
  std::string schemas, channels, counts, chunks;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    schemas += channels_[i].schema_record;
    channels += channels_[i].channel_record;
    counts += number(static_cast<std::uint16_t>(i)) + number(channels_[i].messages);
  }
  for (const ChunkIndex& chunk : chunks_) {
    std::string indexes;
    for (const auto& [id, offset] : chunk.indexes) indexes += number(id) + number(offset);
    chunks += record(mcap::kChunkIndex, number(chunk.first) + number(chunk.last) + number(chunk.start) +
                                            number(chunk.size) + sized(indexes) + number(chunk.indexes_size) +
                                            sized("zstd") + number(chunk.packed) + number(chunk.unpacked));
  }
  group(mcap::kSchema, schemas);
  group(mcap::kChannel, channels);
  group(
      mcap::kStatistics,
      record(mcap::kStatistics, number(messages_) + number(static_cast<std::uint16_t>(schemas_.size())) +
                                    number(static_cast<std::uint32_t>(channels_.size())) + number(std::uint32_t{0}) +
                                    number(std::uint32_t{0}) + number(static_cast<std::uint32_t>(chunks_.size())) +
                                    number(messages_ > 0 ? first_ : std::uint64_t{0}) + number(last_) + sized(counts)));
  group(mcap::kChunkIndex, chunks);
  const std::uint64_t offsets_at = at_;
  put(offsets);
  put(record(mcap::kFooter, number(summary) + number(offsets_at) + number(std::uint32_t{0})));
  put(std::string(mcap::kMagic));
  file_.close();
}

}  // namespace slam
