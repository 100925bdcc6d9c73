// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/zip_file.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>

#include "tools/files.hpp"
#include "tools/unzip.hpp"

namespace slam::zip_file_test {
namespace {

using testing::HasSubstr;

TEST(ZipFile, HoldsTextsAndFilesOfAnySize) {
  const test::Folder folder;
  std::mt19937 random(1);
  std::string large(3'000'000, '\0');
  for (char& c : large) c = static_cast<char>(random());
  ZipFile zip(folder / "a.zip");
  zip.add("text.txt", "some words\n");
  zip.add("empty.txt", "");
  zip.addFile("large.bin", folder.write("large", large));
  zip.close();
  const auto entries = test::unzipped(folder / "a.zip");
  EXPECT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries.at("text.txt"), "some words\n");
  EXPECT_EQ(entries.at("empty.txt"), "");
  EXPECT_TRUE(entries.at("large.bin") == large);
}

TEST(ZipFile, IsGoneWhereItWasNotClosed) {
  const test::Folder folder;
  {
    ZipFile zip(folder / "a.zip");
    EXPECT_THAT(test::refusalOf([&] { zip.addFile("none", folder / "none"); }), HasSubstr("none: cannot read"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.zip"));
}

TEST(ZipFile, OverwritesNothingAndNamesWhatItCannotWrite) {
  const test::Folder folder;
  EXPECT_THAT(test::refusalOf([&] { ZipFile(folder.write("a.zip", "precious")); }), HasSubstr("is there already"));
  EXPECT_EQ(test::contentOf(folder / "a.zip"), "precious");
  EXPECT_THAT(test::refusalOf([&] { ZipFile(folder / "none/a.zip"); }), HasSubstr("a.zip: cannot write"));
}

}  // namespace
}  // namespace slam::zip_file_test
