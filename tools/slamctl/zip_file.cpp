// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/zip_file.hpp"

#include <stdexcept>
#include <vector>

namespace slam {
namespace {

std::ofstream created(const std::filesystem::path& file) {
  if (std::filesystem::exists(file)) throw std::runtime_error(file.string() + ": is there already; give another name");
  std::ofstream out(file, std::ios::binary);
  if (!out) throw std::runtime_error(file.string() + ": cannot write it; is there such a folder, and may you?");
  return out;
}

}  // namespace

ZipFile::ZipFile(std::filesystem::path file)
    : file_(std::move(file)), out_(created(file_)), zip_([this](std::string_view bytes) {
        return out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).good();
      }) {}

ZipFile::~ZipFile() {
  if (closed_) return;
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

void ZipFile::add(const std::string& name, std::string_view content) {
  try {
    zip_.begin(name, std::time(nullptr));
    zip_.write(content);
  } catch (const std::runtime_error&) {
    fail();
  }
}

void ZipFile::addFile(const std::string& name, const std::filesystem::path& from) {
  std::ifstream in(from, std::ios::binary);
  if (!in) throw std::runtime_error(from.string() + ": cannot read it");
  std::vector<char> part(1 << 20);
  try {
    zip_.begin(name, std::time(nullptr));
    while (in.read(part.data(), static_cast<std::streamsize>(part.size())) || in.gcount() > 0)
      zip_.write({part.data(), static_cast<std::size_t>(in.gcount())});
  } catch (const std::runtime_error&) {
    fail();
  }
}

void ZipFile::close() {
  try {
    zip_.close();
  } catch (const std::runtime_error&) {
    fail();
  }
  if (!out_.flush()) fail();
  closed_ = true;
}

void ZipFile::fail() const { throw std::runtime_error(file_.string() + ": cannot write all of it: is the disk full?"); }

}  // namespace slam
