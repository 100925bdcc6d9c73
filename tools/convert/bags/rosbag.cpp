// SPDX-License-Identifier: BSD-3-Clause
// Format: wiki.ros.org/Bags/Format/2.0. A record is a header of name=value fields behind its size, and data behind its.
#include <map>
#include <optional>
#include <string_view>

#include "tools/convert/bags/decompress.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/mapped_file.hpp"
#include "tools/convert/wire_reader.hpp"

namespace slam {
namespace {

constexpr std::size_t kMagic = 13;             // bytes of "#ROSBAG V2.0\n"
constexpr std::size_t kLargestHeader = 65536;  // [bytes] of a record
enum Op : std::uint8_t {
  kNone = 0,
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

using Bytes = std::span<const std::uint8_t>;

/// Calls field(name, value) for each. @return false where they are not fields to the last byte
template <typename Field>
bool forEachField(Bytes bytes, const Field& field) {
  WireReader reader(bytes);
  while (reader.left() > 0) {
    const std::string_view text = reader.text();
    const std::size_t equals = text.find('=');
    if (!reader.ok() || equals == std::string_view::npos || equals == 0) return false;
    field(text.substr(0, equals), text.substr(equals + 1));
  }
  return reader.ok();
}

template <typename T>
std::optional<T> numberIn(std::string_view value) {
  if (value.size() != sizeof(T)) return std::nullopt;
  return WireReader({reinterpret_cast<const std::uint8_t*>(value.data()), value.size()}).number<T>();
}

struct Record {
  std::uint8_t op = kNone;
  std::uint32_t connection = 0;
  std::uint64_t time = 0;  // seconds, and nanoseconds in the upper half
  std::string_view topic, compression;
  Bytes data;
  std::size_t size = 0;  // [bytes] of all of it
  bool complete = true;  // false: its data is cut off
};

/// The record at the beginning of `bytes`, or nullopt where there is none.
std::optional<Record> recordAt(Bytes bytes) {
  WireReader reader(bytes);
  const auto header_size = reader.number<std::uint32_t>();
  if (!reader.ok() || header_size > kLargestHeader) return std::nullopt;
  const Bytes header = reader.take(header_size);
  if (!reader.ok()) return std::nullopt;
  Record record;
  const bool fields = forEachField(header, [&](std::string_view name, std::string_view value) {
    if (name == "op" && value.size() == 1) record.op = static_cast<std::uint8_t>(value[0]);
    if (name == "conn") record.connection = numberIn<std::uint32_t>(value).value_or(0);
    if (name == "time") record.time = numberIn<std::uint64_t>(value).value_or(0);
    if (name == "topic") record.topic = value;
    if (name == "compression") record.compression = value;
  });
  if (!fields || record.op < kMessage || record.op > kConnection) return std::nullopt;
  const auto data_size = reader.number<std::uint32_t>();
  if (!reader.ok()) return std::nullopt;
  record.complete = data_size <= reader.left();
  record.data = reader.take(std::min<std::size_t>(data_size, reader.left()));
  record.size = reader.position();
  return record;
}

/// Where the next record begins at or behind `from`; the end where there is none.
std::size_t nextRecord(Bytes bytes, std::size_t from) {
  constexpr std::uint8_t kOpField[] = {4, 0, 0, 0, 'o', 'p', '='};
  constexpr std::size_t kFarthest = 512;  // [bytes] of other fields before it
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string_view pattern(reinterpret_cast<const char*>(kOpField), sizeof(kOpField));
  for (std::size_t at = text.find(pattern, from); at != std::string_view::npos; at = text.find(pattern, at + 1)) {
    for (std::size_t before = 4; before <= kFarthest && before <= at && at - before >= from; ++before) {
      const auto record = recordAt(bytes.subspan(at - before));
      if (record && record->complete) return at - before;
    }
  }
  return bytes.size();
}

class RosBag : public RosSource {
 public:
  explicit RosBag(const std::filesystem::path& file)
      : RosSource(file), file_(file), rest_(file_.bytes().subspan(std::min(kMagic, file_.bytes().size()))) {}

  bool next(RosMessage& message) override {
    for (;;) {
      Bytes& bytes = chunk_rest_.empty() ? rest_ : chunk_rest_;
      if (bytes.empty()) return false;
      const bool in_chunk = &bytes == &chunk_rest_;
      const auto record = recordAt(bytes);
      if (!record) {
        damage(place() + (in_chunk ? ": damage in a chunk" : ": not a record"));
        bytes = bytes.subspan(nextRecord(bytes, 1));
        continue;
      }
      if (!record->complete && !in_chunk) {
        damage(place() + ": a record that is cut off, or whose size is damaged");
        if (const std::size_t at = nextRecord(bytes, 1); at < bytes.size()) {
          bytes = bytes.subspan(at);
          continue;
        }
      }
      bytes = bytes.subspan(record->size);
      file_.release(rest_);
      if (use(*record, in_chunk, message)) return true;
    }
  }

 private:
  std::string place() const { return name() + ", byte " + std::to_string(file_.bytes().size() - rest_.size()); }

  /// @return true where it is a message
  bool use(const Record& record, bool in_chunk, RosMessage& message) {
    if (record.op == kChunk && !in_chunk) {
      if (record.compression != "none" && record.compression != "bz2" && record.compression != "lz4") {
        damage(place() + ": a chunk of the unknown compression " + std::string(record.compression));
        return false;
      }
      if (!decompress(record.compression, record.data, chunk_) && record.complete) {
        damage(place() + ": a chunk that cannot be unpacked whole");
      }
      countUnpacked(chunk_.size());
      chunk_rest_ = chunk_;
    } else if (record.op == kConnection) {
      connect(record);
    } else if (record.op == kMessage) {
      const auto topic = topics_.find(record.connection);
      if (topic == topics_.end()) {
        damage(place() + ": a message of a connection that is not described");
      } else if (record.complete) {
        constexpr std::int64_t kMicro = 1000000;
        message.topic = &topic->second;
        message.received = static_cast<std::int64_t>(record.time & 0xFFFFFFFFU) * kMicro +
                           static_cast<std::int64_t>(record.time >> 32) / 1000;
        message.data = record.data;
        return true;
      }
    }
    return false;
  }

  void connect(const Record& record) {
    if (topics_.contains(record.connection) || topics_.size() >= kMostTopics) return;
    RosTopic topic{.name = std::string(record.topic), .encoding = RosEncoding::kRos1};
    const bool fields = forEachField(record.data, [&](std::string_view name, std::string_view value) {
      if (name == "type") topic.type = value;
      if (name == "md5sum") topic.md5 = value;
      if (name == "callerid") topic.publisher = value;
      if (name == "message_definition") topic.definition = value;
      if (name == "topic" && topic.name.empty()) topic.name = value;
    });
    if (!fields || topic.type.empty()) {
      damage(place() + ": a damaged connection");
      return;
    }
    topics_.emplace(record.connection, std::move(topic));
  }

  MappedFile file_;
  Bytes rest_, chunk_rest_;
  std::vector<std::uint8_t> chunk_;
  std::map<std::uint32_t, RosTopic> topics_;
};

}  // namespace

std::unique_ptr<RosSource> openRosBag(const std::filesystem::path& file) { return std::make_unique<RosBag>(file); }

}  // namespace slam
