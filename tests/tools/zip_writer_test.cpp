// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/zip_writer.hpp"

#include <gtest/gtest.h>
#include <stdexcept>
#include <string>

#include "tools/files.hpp"
#include "tools/unzip.hpp"

namespace slam::zip_writer_test {
namespace {

TEST(ZipWriter, SendsAllOfItWhileItIsMade) {
  std::string sent;
  ZipWriter zip([&](std::string_view bytes) { return sent.append(bytes), true; }, ZipWriter::Method::kStore);
  zip.begin("run/0001.lcm", 0);
  zip.write(std::string(200'000, 'a'));
  EXPECT_GT(sent.size(), 100'000U) << "it is not kept until the end";
  zip.write("b");
  zip.begin("run/0002.lcm", 0);
  zip.write("abc");
  zip.close();
  const test::Folder folder;
  const auto entries = test::unzipped(folder.write("a.zip", sent));
  EXPECT_EQ(entries.size(), 2U);
  EXPECT_TRUE(entries.at("run/0001.lcm") == std::string(200'000, 'a') + "b");
  EXPECT_EQ(entries.at("run/0002.lcm"), "abc");
}

TEST(ZipWriter, EndsWhereNothingMoreIsTaken) {
  std::size_t taken = 0;
  ZipWriter zip([&](std::string_view bytes) { return (taken += bytes.size()) < 100'000; }, ZipWriter::Method::kStore);
  zip.begin("a", 0);
  EXPECT_THROW(zip.write(std::string(1'000'000, 'a')), std::runtime_error);
  EXPECT_THROW(zip.close(), std::runtime_error);
}

}  // namespace
}  // namespace slam::zip_writer_test
