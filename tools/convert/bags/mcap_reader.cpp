// SPDX-License-Identifier: BSD-3-Clause
// Format: mcap.dev/spec. A record is one byte of kind, its size in 64 bits, and its content.
#include <map>
#include <optional>
#include <zlib.h>

#include "tools/convert/bags/decompress.hpp"
#include "tools/convert/bags/mcap.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/mapped_file.hpp"
#include "tools/convert/wire_reader.hpp"

namespace slam {
namespace {

using Bytes = std::span<const std::uint8_t>;
using mcap::Op;

struct Record {
  Op op;
  Bytes data;
  std::size_t size;
  bool complete;
};

struct Chunk {
  std::uint32_t crc = 0;
  std::string_view compression;
  Bytes records;
};

std::optional<Record> recordAt(Bytes bytes) {
  WireReader reader(bytes);
  const auto op = reader.number<std::uint8_t>();
  const auto size = reader.number<std::uint64_t>();
  if (!reader.ok() || op < mcap::kHeader || op > mcap::kDataEnd) return std::nullopt;
  const bool complete = size <= reader.left();
  const Bytes data = reader.take(complete ? static_cast<std::size_t>(size) : reader.left());
  return Record{static_cast<Op>(op), data, reader.position(), complete};
}

/// @param complete false: its end may be missing
std::optional<Chunk> chunkIn(const Record& record) {
  WireReader reader(record.data);
  reader.skip<std::uint64_t>(3);  // times, size
  Chunk chunk;
  chunk.crc = reader.number<std::uint32_t>();
  chunk.compression = reader.text();
  const auto size = reader.number<std::uint64_t>();
  const bool known = chunk.compression.empty() || chunk.compression == "lz4" || chunk.compression == "zstd";
  if (!reader.ok() || !known || (record.complete && size != reader.left())) return std::nullopt;
  chunk.records = reader.take(std::min<std::size_t>(size, reader.left()));
  return chunk;
}

class McapFile : public RosSource {
 public:
  explicit McapFile(const std::filesystem::path& file) : RosSource(file), file_(file) {
    rest_ = file_.bytes().subspan(std::min(mcap::kMagic.size(), file_.bytes().size()));
  }

  bool next(RosMessage& message) override {
    for (;;) {
      const bool in_chunk = !chunk_rest_.empty();
      Bytes& bytes = in_chunk ? chunk_rest_ : rest_;
      if (bytes.empty()) return false;
      const auto record = recordAt(bytes);
      const bool plausible = record && (in_chunk || !damaged_ || isPlausible(*record));
      if (!record || !plausible || (in_chunk && !record->complete) ||
          (!in_chunk && !record->complete && !cutOff(*record))) {
        if (in_chunk) {
          if (!chunk_cut_) damage(place() + ": damage in a chunk");
          chunk_rest_ = {};
          continue;
        }
        if (!damaged_) damage(place() + ": not a record");
        damaged_ = true;
        bytes = bytes.subspan(nextPlausible(bytes));
        continue;
      }
      damaged_ = false;
      if (!record->complete) {
        damage(place() + ": a record that is cut off, or whose size is damaged");
        if (const std::size_t at = nextPlausible(bytes); at < bytes.size()) {
          bytes = bytes.subspan(at);
          continue;
        }
      }
      if (!in_chunk && (record->op == mcap::kDataEnd || record->op == mcap::kFooter)) {
        rest_ = {};
        return false;
      }
      bytes = bytes.subspan(record->size);
      file_.release(rest_);
      if (use(*record, in_chunk, message)) return true;
    }
  }

 private:
  std::string place() const { return name() + ", byte " + std::to_string(file_.bytes().size() - rest_.size()); }

  /// A record that goes on behind the end of the file: the last one of a recorder that was stopped.
  static bool cutOff(const Record& record) {
    return record.op == mcap::kMessage || (record.op == mcap::kChunk && chunkIn(record).has_value());
  }
  /// After a damage, only what can hardly be anything else counts as a record.
  bool isPlausible(const Record& record) const {
    if (record.op == mcap::kChunk) return chunkIn(record).has_value();
    if (record.op != mcap::kMessage || !record.complete || record.data.size() < 22) return false;
    return channels_.contains(WireReader(record.data).number<std::uint16_t>());
  }
  std::size_t nextPlausible(Bytes bytes) const {
    for (std::size_t at = 1; at < bytes.size(); ++at) {
      if (bytes[at] != mcap::kChunk && bytes[at] != mcap::kMessage) continue;
      const auto record = recordAt(bytes.subspan(at));
      if (record && record->complete && isPlausible(*record)) return at;
    }
    return bytes.size();
  }

  bool use(const Record& record, bool in_chunk, RosMessage& message) {
    WireReader reader(record.data);
    if (record.op == mcap::kChunk && !in_chunk) {
      openChunk(record);
    } else if (record.op == mcap::kSchema && record.complete) {
      const auto id = reader.number<std::uint16_t>();
      Schema schema;
      schema.type = reader.text();
      schema.encoding = reader.text();
      schema.text = reader.text();
      if (reader.ok() && schemas_.size() < kMostTopics) schemas_.insert_or_assign(id, std::move(schema));
    } else if (record.op == mcap::kChannel && record.complete) {
      connect(reader);
    } else if (record.op == mcap::kMessage && record.complete) {
      const auto channel = channels_.find(reader.number<std::uint16_t>());
      reader.number<std::uint32_t>();  // sequence
      const auto received = reader.number<std::uint64_t>();
      reader.number<std::uint64_t>();  // when it was published
      if (!reader.ok() || channel == channels_.end()) {
        damage(place() + ": a message of a channel that is not described");
        return false;
      }
      message.topic = &channel->second;
      message.received = static_cast<std::int64_t>(received / 1000);
      message.data = reader.take(reader.left());
      return true;
    }
    return false;
  }

  void openChunk(const Record& record) {
    const auto chunk = chunkIn(record);
    if (!chunk) {
      damage(place() + ": a chunk whose head is damaged, or of an unknown compression");
      return;
    }
    const bool whole = decompress(chunk->compression, chunk->records, chunk_);
    countUnpacked(chunk_.size());
    const bool wrong = whole && chunk->crc != 0 && record.complete &&
                       ::crc32(0, chunk_.data(), static_cast<unsigned>(chunk_.size())) != chunk->crc;
    if (record.complete && (!whole || wrong)) damage(place() + ": a damaged chunk");
    // What is wrong by its checksum has a wrong byte somewhere, and no record in it can be trusted.
    if (wrong) chunk_.clear();
    chunk_cut_ = !whole;
    chunk_rest_ = chunk_;
  }

  void connect(WireReader& reader) {
    const auto id = reader.number<std::uint16_t>(), schema_id = reader.number<std::uint16_t>();
    RosTopic topic;
    topic.name = reader.text();
    const std::string_view encoding = reader.text();
    if (!reader.ok() || channels_.contains(id) || channels_.size() >= kMostTopics) return;
    topic.encoding = encoding == "cdr"    ? RosEncoding::kCdr
                     : encoding == "ros1" ? RosEncoding::kRos1
                                          : RosEncoding::kOther;
    if (const auto schema = schemas_.find(schema_id); schema != schemas_.end()) {
      topic.type = rosTypeName(schema->second.type);
      const std::string& language = schema->second.encoding;
      if (language == "ros1msg" || language == "ros2msg") {
        topic.definition = schema->second.text;
      } else if (!language.empty()) {
        topic.remark = "its messages are described in " + language + ", which is not read";
      }
    }
    if (topic.encoding == RosEncoding::kOther) {
      topic.remark = "its messages are written in " + std::string(encoding) + ", which is not read";
    }
    channels_.emplace(id, std::move(topic));
  }

  struct Schema {
    std::string type, encoding, text;
  };
  MappedFile file_;
  Bytes rest_, chunk_rest_;
  std::vector<std::uint8_t> chunk_;
  bool damaged_ = false;    // looking for the next record
  bool chunk_cut_ = false;  // its end is missing, which was counted already
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, RosTopic> channels_;
};

}  // namespace

std::unique_ptr<RosSource> openMcap(const std::filesystem::path& file) { return std::make_unique<McapFile>(file); }

}  // namespace slam
