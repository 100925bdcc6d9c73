// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tools/common/output_file.hpp"

namespace slam {

/// Writes an MCAP file of JSON messages, or of ROS 2's (mcap.dev/spec): chunks packed by zstd, with the indexes and the
/// summary by which a viewer jumps to any time.
class McapWriter {
 public:
  enum class Messages : std::uint8_t { kJson, kRos2 };  ///< how they and their schemas are encoded
  /// @throws std::runtime_error when the file cannot be written
  explicit McapWriter(const std::filesystem::path& file, Messages encoding = Messages::kJson);

  /// @param schema name of the messages' type, as viewers know it @param description of it: JSON Schema, or
  /// the text of ROS 2's definition
  /// @return the channel, for write()
  std::uint16_t addChannel(const std::string& topic, const std::string& schema, const std::string& description);

  /// @param received [us since the epoch] @param utime [us since the epoch] of the message itself
  void write(std::uint16_t channel, std::int64_t received, std::int64_t utime, std::string_view message);

  /// Writes what is left, the summary and the end. @throws std::runtime_error when the disk did not take all
  void close();

  std::uint64_t messages() const { return messages_; }

 private:
  struct ChunkIndex {
    std::uint64_t first, last, start, size, indexes_size, packed, unpacked;
    std::map<std::uint16_t, std::uint64_t> indexes;  // offset of each channel's message index
  };
  struct Channel {
    std::string schema_record, channel_record;
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> in_chunk;  // [ns] and offset of each message
  };

  void put(const std::string& bytes);
  void endChunk();

  OutputFile file_;
  Messages encoding_;
  std::uint64_t at_ = 0;
  std::map<std::string, std::uint16_t> schemas_;
  std::vector<Channel> channels_;  // channel n is at n
  std::string chunk_;
  std::vector<ChunkIndex> chunks_;
  std::uint64_t first_ = ~std::uint64_t{0}, last_ = 0, chunk_first_ = ~std::uint64_t{0}, chunk_last_ = 0;  // [ns]
  std::uint64_t messages_ = 0;
};

}  // namespace slam
