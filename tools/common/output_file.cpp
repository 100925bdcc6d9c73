// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <stdexcept>
#include <string>
#include <unistd.h>

namespace slam {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": cannot write: " + why);
}

const fs::path& prepared(const fs::path& file) {
  prepareOutput(file);
  return file;
}

}  // namespace

void prepareOutput(const fs::path& file) {
  if (file.empty()) return;
  const fs::path folder = fs::absolute(file).parent_path();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) refuse(file, "its folder cannot be made: " + error.message());
  if (!file.has_filename() || fs::is_directory(file, error)) refuse(file, "it is a folder, not a file");
  if (fs::exists(file, error)) {
    if (::access(file.c_str(), W_OK) != 0) refuse(file, std::strerror(errno));
    return;
  }
  if (fs::is_symlink(file, error)) return;  // to a file that is not there yet
  // Rights alone do not tell: root may write anywhere, but not on another computer's disk.
  const int made = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (made < 0) refuse(file, std::strerror(errno));
  ::close(made);
  ::unlink(file.c_str());
}

void prepareMapFiles(const fs::path& prefix) {
  if (prefix.empty()) return;
  for (const char* ending : {".yaml", ".pgm", ".png"}) {
    prepareOutput(prefix.string() + ending);
    prepareOutput(prefix.string() + ending + ".new");
  }
}

OutputFile::OutputFile(const fs::path& file) : file_(file), out_(prepared(file)) {
  if (!out_) throw std::runtime_error(file.string() + ": cannot write: " + std::strerror(errno));
}

void OutputFile::close() {
  out_.close();
  if (!out_) throw std::runtime_error(file_.string() + ": cannot write all of it: " + std::strerror(errno));
}

}  // namespace slam
