// SPDX-License-Identifier: BSD-3-Clause
#include "store/durable_file.hpp"

#include <csignal>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

#include "store/sync_log.hpp"
#include "support/file_size_limit.hpp"
#include "tools/files.hpp"

namespace slam::durable_file_test {
namespace {

using test::contentOf;
using test::FileSizeLimit;
using test::Folder;
using test::refusalOf;

TEST(DurableFile, ReadsBackWhatItWrote) {
  const Folder folder;
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  for (const std::string& content : {all, std::string(), std::string(1 << 20, 'x'), std::string("short")}) {
    writeDurably(folder / "file", content);  // over the one before
    EXPECT_TRUE(readFile(folder / "file", content.size()) == content);
  }
  syncFolder(folder / "");
}

TEST(DurableFile, NamesFileAndReason) {
  const Folder folder;
  folder.write("file", "x");
  using testing::HasSubstr;
  EXPECT_THAT(refusalOf([&] { readFile(folder / "missing", 1); }), HasSubstr("missing: cannot read: No such file"));
  EXPECT_THAT(refusalOf([&] { readFile(folder / "", 1); }), HasSubstr("cannot read"));
  EXPECT_THAT(refusalOf([&] { writeDurably(folder / "no/file", "x"); }), HasSubstr("no/file: cannot open: No such"));
  EXPECT_THAT(refusalOf([&] { AppendFile(folder / "no/file", 0); }), HasSubstr("cannot open"));
  EXPECT_THAT(refusalOf([&] { syncFolder(folder / "file"); }), HasSubstr("Not a directory"));
}

TEST(DurableFile, ReportsThatTheDiskIsFull) {
  const Folder folder;
  const FileSizeLimit limit(1000);
  EXPECT_THAT(refusalOf([&] { writeDurably(folder / "file", std::string(1001, 'x')); }),
              testing::HasSubstr("cannot write: File too large"));
}

TEST(DurableFile, ReadsNothingOfWhatIsNoFileAndWaitsForNobody) {
  const Folder folder;
  using testing::HasSubstr;
  const std::string pipe = folder / "pipe", socket = folder / "socket";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  ASSERT_EQ(mknod(socket.c_str(), S_IFSOCK | 0600, 0), 0);
  std::filesystem::create_symlink("loop", folder / "loop");
  std::filesystem::create_symlink(pipe, folder / "link");
  for (const auto& [name, words] : {std::pair<std::string, const char*>{pipe, "it is a pipe, not a file"},
                                    {folder / "link", "it is a pipe, not a file"},
                                    {socket, "it is a socket, not a file"},
                                    {folder / "", "it is a folder, not a file"},
                                    {"/dev/zero", "it is a device, not a file"},
                                    {folder / "loop", "Too many levels of symbolic links"},
                                    {"/proc/self/mem", "Input/output error"}}) {
    EXPECT_THAT(refusalOf([&] { readFile(name, 100); }), testing::AllOf(HasSubstr("cannot read: "), HasSubstr(words)))
        << name;
  }
}

TEST(DurableFile, ReadsNothingOfAFileThatIsLargerThanItMayBe) {
  const Folder folder;
  folder.write("file", "12345");
  EXPECT_EQ(readFile(folder / "file", 5), "12345");
  EXPECT_THAT(refusalOf([&] { readFile(folder / "file", 4); }), testing::HasSubstr("it has 5 bytes, not 4 or fewer"));
  std::filesystem::resize_file(folder / "file", 40'000'000'000);  // without blocks on the disk
  EXPECT_NE(refusalOf([&] { readFile(folder / "file", 1'000'000'000); }), "");
  InputFile in(folder / "file");
  EXPECT_EQ(in.read(3), "123");
  EXPECT_EQ(in.read(2), "45");
  EXPECT_LT(readFile("/proc/self/status", 10'000'000).size(), 100'000U) << "a file whose size its folder does not say";
}

TEST(DurableFile, WaitsForTheDiskAndReportsWhenItDoesNotTakeIt) {
  const Folder folder;
  test::syncLog().clear();
  writeDurably(folder / "file", "x");
  syncFolder(folder / "");
  AppendFile file(folder / "journal", 0);
  file.append("x");
  file.sync();
  EXPECT_THAT(test::syncLog(), testing::ElementsAre((folder / "file").string(), (folder / "").parent_path().string(),
                                                    (folder / "journal").string()));
  // Devices take what is written and cannot sync it.
  using testing::HasSubstr;
  EXPECT_THAT(refusalOf([] { writeDurably("/dev/null", "x"); }), HasSubstr("/dev/null: cannot sync"));
  EXPECT_THAT(refusalOf([] { syncFolder("/proc"); }), HasSubstr("/proc: cannot sync"));
  EXPECT_THAT(refusalOf([] { AppendFile("/dev/null", 0).sync(); }), HasSubstr("/dev/null: cannot sync"));
}

TEST(Replacement, TakesAFilesPlaceWholeOrNotAtAll) {
  const Folder folder;
  folder.write("file", "before");
  std::filesystem::create_symlink("elsewhere", folder / "file.new");
  {
    Replacement next(folder / "file");
    writeDurably(next.draft(), "ha");
    EXPECT_EQ(contentOf(folder / "file"), "before");
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "file.new"));
  EXPECT_FALSE(std::filesystem::exists(folder / "elsewhere")) << "a link in the draft's place is not followed";
  Replacement next(folder / "file", ".part");
  writeDurably(next.draft(), "after", 0600);
  test::syncLog().clear();
  next.putInPlace();
  EXPECT_THAT(test::syncLog(), testing::ElementsAre((folder / "").parent_path().string()));
  EXPECT_EQ(contentOf(folder / "file"), "after");
  EXPECT_EQ(std::filesystem::status(folder / "file").permissions(), std::filesystem::perms(0600));
  EXPECT_THAT(refusalOf([&] { Replacement(folder / "other").putInPlace(); }),
              testing::HasSubstr("other: cannot replace: No such file"));
}

TEST(DurableFile, ChecksumsAsZlibDoes) {
  EXPECT_EQ(crc32Of(""), 0U);
  EXPECT_EQ(crc32Of("123456789"), 0xCBF43926U);
}

TEST(AppendFile, GoesOnBehindWhatIsToBeKept) {
  const Folder folder;
  {
    AppendFile file(folder / "file", 0);
    file.append("one ");
    file.append("two ");
    file.sync();
  }
  EXPECT_EQ(contentOf(folder / "file"), "one two ");
  AppendFile(folder / "file", 4).append("three");
  EXPECT_EQ(contentOf(folder / "file"), "one three");
  AppendFile(folder / "file", 0).append("new");
  EXPECT_EQ(contentOf(folder / "file"), "new");
}

TEST(AppendFile, TakesBackTheHalfThatFitted) {
  const Folder folder;
  AppendFile file(folder / "file", 0);
  file.append(std::string(700, 'a'));
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(file.append(std::string(700, 'b')), std::runtime_error);
    EXPECT_EQ(contentOf(folder / "file"), std::string(700, 'a'));
    file.append("c");  // there is room for that
  }
  file.append("d");
  EXPECT_EQ(contentOf(folder / "file"), std::string(700, 'a').append("cd"));  // no sum: GCC 12 sees it overflow at -O1
}

TEST(AppendFile, GoesOnBehindAllThereIs) {
  const Folder folder;
  AppendFile(folder / "file", AppendFile::kAll).append("one ");
  AppendFile(folder / "file", AppendFile::kAll).append("two");
  EXPECT_EQ(contentOf(folder / "file"), "one two");
}

TEST(AppendFile, DetectsWhenSomebodyHasRemovedIt) {
  const Folder folder;
  AppendFile file(folder / "file", 0);
  EXPECT_TRUE(file.isThere());
  std::filesystem::remove(folder / "file");
  EXPECT_FALSE(file.isThere());
  std::filesystem::create_directory(folder / "map");
  const FolderLock lock(folder / "map");
  EXPECT_TRUE(lock.isThere());
  std::filesystem::remove_all(folder / "map");
  EXPECT_FALSE(lock.isThere());
}

TEST(AppendFile, TakesAPipeThatIsRead) {
  const Folder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(refusalOf([&] { AppendFile(pipe, 0); }), testing::HasSubstr("cannot open")) << "it would wait for ever";
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  AppendFile(pipe, 0).append("one");
  char text[8] = {};
  EXPECT_EQ(read(reader, text, sizeof text), 3);
  EXPECT_STREQ(text, "one");
  close(reader);
}

}  // namespace
}  // namespace slam::durable_file_test
