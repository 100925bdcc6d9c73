// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grey_picture.hpp"

#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "mapping/picture_files.hpp"

namespace slam::grey_picture_test {
namespace {

namespace fs = std::filesystem;
using test::png;
using testing::ElementsAre;
using testing::HasSubstr;
using namespace std::string_literals;

class GreyPictures : public testing::Test {
 protected:
  ~GreyPictures() override { fs::remove(file_); }
  GreyPicture read(const std::string& content) const {
    std::ofstream(file_, std::ios::binary) << content;
    return readGreyPicture(file_);
  }
  std::string errorOf(const std::string& content) const {
    try {
      read(content);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  }

  fs::path file_ = fs::path(testing::TempDir()) / ("slamd_picture_" + std::to_string(getpid()));
};

TEST_F(GreyPictures, OfBinaryPgmHaveEightBitsOrSixteen) {
  const GreyPicture eight = read("P5\n# CREATOR: map_saver 0.05 m/pix\n3 2\n255\n\x00\x0A\xCD\xFA\xFF\x01"s);
  EXPECT_EQ(eight.width, 3);
  EXPECT_EQ(eight.height, 2);
  EXPECT_THAT(eight.greys, ElementsAre(0, 10, 205, 250, 255, 1));
  EXPECT_TRUE(eight.see_through.empty());
  EXPECT_THAT(read("P5 2 1 65535\n\xFF\xFF\x80\x00"s).greys, ElementsAre(255, 128));
  EXPECT_THAT(read("P5 3 1 100\n\x00\x32\x64"s).greys, ElementsAre(0, 128, 255)) << "in 255ths of the greatest value";
}

TEST_F(GreyPictures, OfPgmInTextHaveBlanksAndCommentsAnywhere) {
  EXPECT_THAT(read("P2\n2 2\n255\n0 10\n205 250\n").greys, ElementsAre(0, 10, 205, 250));
  EXPECT_THAT(read("P2 # 9\n2#8\n 2 255 0\t10 # 7\r\n205\n\n250").greys, ElementsAre(0, 10, 205, 250));
  EXPECT_THAT(read("P2 2 1 1\n0 1\n").greys, ElementsAre(0, 255));
}

TEST_F(GreyPictures, OfPngAreReadFromEachKindOfIt) {
  using K = test::PngKind;
  const std::vector<std::uint8_t> greys = {0, 85, 170, 255, 205, 254};
  for (const K kind : {K::kGrey, K::kGrey16, K::kColour, K::kPalette, K::kInterlaced, K::kLinear}) {
    const GreyPicture picture = read(png(3, 2, greys, kind));
    EXPECT_EQ(picture.width, 3);
    EXPECT_EQ(picture.height, 2);
    EXPECT_EQ(picture.greys, greys) << static_cast<int>(kind);
    EXPECT_TRUE(picture.see_through.empty());
  }
  EXPECT_THAT(read(png(3, 1, {0, 255, 0}, K::kBlackAndWhite)).greys, ElementsAre(0, 255, 0));
}

TEST_F(GreyPictures, OfPngKeepWhatIsNotOpaqueApart) {
  using K = test::PngKind;
  for (const K kind : {K::kGreyOpacity, K::kColourOpacity}) {  // opacities 255, 254, 0
    const GreyPicture picture = read(png(3, 1, {7, 254, 0}, kind));
    EXPECT_THAT(picture.greys, ElementsAre(7, 254, 0));
    EXPECT_THAT(picture.see_through, ElementsAre(false, true, true));
  }
  EXPECT_THAT(read(png(3, 1, {7, 254, 0}, K::kGreyKeyed)).see_through, ElementsAre(false, true, false)) << "254 is";
}

TEST_F(GreyPictures, OfOtherKindsAreRefused) {
  for (const std::string& other : {""s, "P"s, "P6\n1 1\n255\nabc"s, "P1\n1 1\n0\n"s, "BM..."s, "\x89PNG\r\n"s})
    EXPECT_THAT(errorOf(other), HasSubstr("the only pictures of a map that slamd reads")) << other;
}

TEST_F(GreyPictures, OfDamagedPgmAreRefusedWithTheReason) {
  for (const char* const header :
       {"P5\n2", "P5\n-2 -2\n255\n", "P2\nx", "P5\n2 2\n0\n", "P5\n2 2\n65536\n", "P2\n2 2\n"})
    EXPECT_THAT(errorOf(header), HasSubstr("header is not that of a PGM")) << header;
  EXPECT_THAT(errorOf("P5\n2 2\n255\n123"), HasSubstr("shorter than its header says"));
  EXPECT_THAT(errorOf("P5\n2 2\n256\n\0\1\0\1\0\1\0"s), HasSubstr("shorter than its header says"));
  EXPECT_THAT(errorOf("P2\n2 2\n255\n1 2 3       "), HasSubstr("shorter than its header says"));
  EXPECT_THAT(errorOf("P2\n2 1\n255\n0 256\n"), HasSubstr("no number from 0 to its greatest"));
  EXPECT_THAT(errorOf("P2\n2 1\n255\n0 99999999999999999999\n"), HasSubstr("no number from 0 to its greatest"));
  EXPECT_THAT(errorOf("P2\n2 1\n255\n0 -1\n"), HasSubstr("no number from 0 to its greatest"));
  EXPECT_THAT(errorOf("P5\n2 1\n100\n\x01\x65"), HasSubstr("above the greatest one"));
  EXPECT_THAT(errorOf("P5\n0 2\n255\n"), HasSubstr("0 x 2 cells are not"));
  EXPECT_THAT(errorOf("P5\n99999999999999999999 2\n255\n"), HasSubstr("1000000000 x 2 cells are not"));
}

TEST_F(GreyPictures, OfDamagedPngAreRefusedWithTheReason) {
  const std::string whole = png(40, 30, std::vector<std::uint8_t>(1200, 99), test::PngKind::kGrey);
  for (std::size_t size = 8; size < whole.size(); size += 3)
    EXPECT_THAT(errorOf(whole.substr(0, size)), testing::AnyOf(HasSubstr("damaged PNG"), HasSubstr("shorter"))) << size;
  for (std::size_t at = 8; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    errorOf(damaged);  // a chunk that is left out, or refused
  }
}

TEST_F(GreyPictures, AreReadNoFurtherThanTheirHeaderReaches) {
  std::ofstream(file_, std::ios::binary) << "P5\n2 1\n255\n\x01\x02";
  fs::resize_file(file_, 40'000'000'000);  // without blocks on the disk
  EXPECT_THAT(readGreyPicture(file_).greys, ElementsAre(1, 2));
  EXPECT_THAT(errorOf("P2\n1 1\n255\n" + std::string(100'000, ' ')), HasSubstr("more blanks and comments"));
  EXPECT_THAT(errorOf("P5\n#" + std::string(100'000, 'x')), HasSubstr("header is not that of a PGM"));
}

TEST_F(GreyPictures, ThatAreTooLargeTakeNoMemory) {
  for (const int side : {20'000, 2'000'000'000}) {
    const std::string sides = std::to_string(side) + " " + std::to_string(side);
    EXPECT_THAT(errorOf("P5\n" + sides + "\n255\n"), HasSubstr("cells are not 1 to"));
    EXPECT_THAT(errorOf("P2\n" + sides + "\n255\n"), HasSubstr("cells are not 1 to"));
    EXPECT_THAT(errorOf(test::pngHeader(side, side)), HasSubstr("cells are not 1 to")) << side;
  }
  EXPECT_THAT(errorOf("P5\n10000 10000\n255\n"), HasSubstr("shorter than its header says"));
  EXPECT_THAT(errorOf(test::pngHeader(10'000, 10'000)), HasSubstr("shorter than its header says"));
}

TEST_F(GreyPictures, ThatAreNoFilesAreNotWaitedFor) {
  ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
  try {
    readGreyPicture(file_);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot read: it is no file"));
  }
}

}  // namespace
}  // namespace slam::grey_picture_test
