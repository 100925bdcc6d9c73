// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/zip_file.hpp"

#include <ctime>
#include <fstream>
#include <minizip/zip.h>
#include <stdexcept>
#include <vector>

namespace slam {

ZipFile::ZipFile(std::filesystem::path file) : file_(std::move(file)) {
  if (std::filesystem::exists(file_))
    throw std::runtime_error(file_.string() + ": is there already; give another name");
  zip_ = zipOpen64(file_.c_str(), APPEND_STATUS_CREATE);
  if (zip_ == nullptr)
    throw std::runtime_error(file_.string() + ": cannot write it; is there such a folder, and may you?");
}

ZipFile::~ZipFile() {
  if (zip_ == nullptr) return;
  zipClose(zip_, nullptr);
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

void ZipFile::begin(const std::string& name) {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  zip_fileinfo info{};
  info.tmz_date.tm_sec = static_cast<uInt>(utc.tm_sec);
  info.tmz_date.tm_min = static_cast<uInt>(utc.tm_min);
  info.tmz_date.tm_hour = static_cast<uInt>(utc.tm_hour);
  info.tmz_date.tm_mday = static_cast<uInt>(utc.tm_mday);
  info.tmz_date.tm_mon = static_cast<uInt>(utc.tm_mon);
  info.tmz_date.tm_year = static_cast<uInt>(utc.tm_year + 1900);
  const int result = zipOpenNewFileInZip64(zip_, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                                           Z_DEFAULT_COMPRESSION, 1);
  if (result != ZIP_OK) fail();
}

void ZipFile::write(std::string_view content) {
  if (zipWriteInFileInZip(zip_, content.data(), static_cast<unsigned>(content.size())) != ZIP_OK) fail();
}

void ZipFile::end() {
  if (zipCloseFileInZip(zip_) != ZIP_OK) fail();
}

void ZipFile::add(const std::string& name, std::string_view content) {
  begin(name);
  write(content);
  end();
}

void ZipFile::addFile(const std::string& name, const std::filesystem::path& from) {
  std::ifstream in(from, std::ios::binary);
  if (!in) throw std::runtime_error(from.string() + ": cannot read it");
  begin(name);
  std::vector<char> part(1 << 20);
  while (in.read(part.data(), static_cast<std::streamsize>(part.size())) || in.gcount() > 0)
    write({part.data(), static_cast<std::size_t>(in.gcount())});
  end();
}

void ZipFile::close() {
  const int result = zipClose(zip_, nullptr);
  zip_ = nullptr;
  if (result == ZIP_OK) return;
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  fail();
}

void ZipFile::fail() const { throw std::runtime_error(file_.string() + ": cannot write all of it: is the disk full?"); }

}  // namespace slam
