// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/bags/mcap_writer.hpp"

#include <gtest/gtest.h>
#include <set>

#include "tools/convert/bags/mcap.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/wire_reader.hpp"
#include "tools/files.hpp"

namespace slam::mcap_writer_test {
namespace {

constexpr int kMessages = 3000;
const std::string kText(1000, 'x');  // so that there are several chunks

void writeFile(const std::filesystem::path& file) {
  McapWriter writer(file);
  const auto a = writer.addChannel("/a", "slam.a", "{}"), b = writer.addChannel("/b", "slam.a", "{}");
  for (int i = 0; i < kMessages; ++i)
    writer.write(i % 3 == 0 ? b : a, 1'000'000 + i, 500'000 + i,
                 "{\"i\":" + std::to_string(i) + ",\"" + kText + "\":0}");
  EXPECT_EQ(writer.messages(), static_cast<std::uint64_t>(kMessages));
  writer.close();
}

struct Record {
  std::uint8_t op;
  std::span<const std::uint8_t> data;
};

Record recordAt(std::span<const std::uint8_t> file, std::uint64_t offset) {
  WireReader reader(file.subspan(offset));
  const auto op = reader.number<std::uint8_t>();
  const auto size = reader.number<std::uint64_t>();
  EXPECT_LE(size, reader.left());
  return {op, reader.take(size)};
}

TEST(McapWriter, WritesMessagesThatAReaderGetsBackInOrder) {
  const test::Folder folder;
  writeFile(folder / "out.mcap");
  const auto source = openMcap(folder / "out.mcap");
  RosMessage message;
  int count = 0;
  for (; source->next(message); ++count) {
    EXPECT_EQ(message.topic->name, count % 3 == 0 ? "/b" : "/a");
    EXPECT_EQ(message.topic->type, "slam.a");
    EXPECT_EQ(message.received, 1'000'000 + count);
    const std::string text(message.data.begin(), message.data.end());
    EXPECT_EQ(text.substr(0, text.find(',')), "{\"i\":" + std::to_string(count));
  }
  EXPECT_EQ(count, kMessages);
  EXPECT_EQ(source->damages(), 0) << source->firstDamage();
}

TEST(McapWriter, HasASummaryByWhichEveryChunkAndMessageIsFound) {
  const test::Folder folder;
  writeFile(folder / "out.mcap");
  const std::string text = test::contentOf(folder / "out.mcap");
  const std::span<const std::uint8_t> file(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  ASSERT_TRUE(text.starts_with(mcap::kMagic) && text.ends_with(mcap::kMagic));
  const std::uint64_t footer = text.size() - mcap::kMagic.size() - (1 + 8 + 8 + 8 + 4);
  const Record end = recordAt(file, footer);
  ASSERT_EQ(end.op, mcap::kFooter);
  WireReader ends(end.data);
  const auto summary = ends.number<std::uint64_t>(), offsets = ends.number<std::uint64_t>();
  std::multiset<std::uint8_t> kinds;
  std::uint64_t messages = 0, indexed = 0;
  for (std::uint64_t at = summary; at < offsets;) {
    const Record record = recordAt(file, at);
    kinds.insert(record.op);
    at += 9 + record.data.size();
    WireReader reader(record.data);
    if (record.op == mcap::kStatistics) messages = reader.number<std::uint64_t>();
    if (record.op != mcap::kChunkIndex) continue;
    reader.skip<std::uint64_t>(2);
    const auto chunk = reader.number<std::uint64_t>(), size = reader.number<std::uint64_t>();
    EXPECT_EQ(recordAt(file, chunk).op, mcap::kChunk);
    EXPECT_EQ(recordAt(file, chunk).data.size() + 9, size);
    const auto bytes = reader.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < bytes / 10; ++i) {
      reader.skip<std::uint16_t>(1);
      const Record index = recordAt(file, reader.number<std::uint64_t>());
      EXPECT_EQ(index.op, mcap::kMessageIndex);
      indexed += (index.data.size() - 6) / 16;
    }
  }
  EXPECT_EQ(messages, static_cast<std::uint64_t>(kMessages));
  EXPECT_EQ(indexed, messages);
  EXPECT_EQ(kinds.count(mcap::kSchema), 1U);
  EXPECT_EQ(kinds.count(mcap::kChannel), 2U);
  EXPECT_GT(kinds.count(mcap::kChunkIndex), 2U);
  for (std::uint64_t at = offsets; at < footer; at += 9 + recordAt(file, at).data.size()) {
    WireReader reader(recordAt(file, at).data);
    const auto op = reader.number<std::uint8_t>();
    EXPECT_EQ(recordAt(file, reader.number<std::uint64_t>()).op, op);
  }
}

}  // namespace
}  // namespace slam::mcap_writer_test
