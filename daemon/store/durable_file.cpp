// SPDX-License-Identifier: BSD-3-Clause
#include "store/durable_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <stdexcept>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <zlib.h>

namespace slam {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  const int error = errno;
  throw DiskError(file.string() + ": " + what + ": " + std::strerror(error), error);
}

constexpr std::uint64_t kBlock = 1 << 16;  // [bytes] read at once where a file's size is not known

/// What has a file's name and is none.
const char* kindOf(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  return S_ISSOCK(mode) ? "a socket" : "a device";
}

[[noreturn]] void failAsNoFile(const std::filesystem::path& file, const char* what, mode_t mode) {
  throw DiskError(file.string() + ": " + what + ": it is " + kindOf(mode) + ", not a file",
                  S_ISDIR(mode) ? EISDIR : EEXIST);
}

int openOrFail(const std::filesystem::path& file, int flags, const char* what = "cannot open", mode_t rights = 0644) {
  const int descriptor = ::open(file.c_str(), flags | O_CLOEXEC, rights);
  if (descriptor >= 0) return descriptor;
  struct stat status {};
  const int error = errno;
  if (error == ENXIO && ::stat(file.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) {
    failAsNoFile(file, what, status.st_mode);
  }
  errno = error;
  fail(file, what);
}

void writeAll(const std::filesystem::path& file, int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(file, "cannot write");
    content.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// Whether a name leads to what is open: it was not removed, and its disk is still the one mounted there.
bool leadsTo(const std::filesystem::path& file, int descriptor) {
  struct stat open {
  }, named{};
  return ::fstat(descriptor, &open) == 0 && ::stat(file.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

/// Closes a descriptor whatever happens.
struct Closer {
  int descriptor;
  ~Closer() { ::close(descriptor); }
};

}  // namespace

void writeDurably(const std::filesystem::path& file, std::string_view content, mode_t rights) {
  const Closer out{openOrFail(file, O_WRONLY | O_CREAT | O_TRUNC, "cannot open", rights)};
  writeAll(file, out.descriptor, content);
  if (::fsync(out.descriptor) != 0) fail(file, "cannot sync");
}

Replacement::Replacement(std::filesystem::path file, const std::string& ending)
    : file_(std::move(file)), draft_(file_.string() + ending) {
  std::error_code ignored;  // whoever writes the draft names what is in the way
  std::filesystem::remove(draft_, ignored);
}

Replacement::~Replacement() {
  std::error_code ignored;
  std::filesystem::remove(draft_, ignored);
}

void Replacement::putInPlace() {
  if (::rename(draft_.c_str(), file_.c_str()) != 0) fail(file_, "cannot replace");
  syncFolder(file_.parent_path());
}

FolderLock::FolderLock(const std::filesystem::path& folder)
    : file_(folder / "lock"), descriptor_(openOrFail(file_, O_RDWR | O_CREAT)) {
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int reason = errno;
  ::close(descriptor_);
  if (reason == EWOULDBLOCK) throw FolderLocked(folder.string() + ": another slamd or slam-replay writes here");
  errno = reason;
  fail(file_, "cannot lock");
}

FolderLock::~FolderLock() { ::close(descriptor_); }

bool FolderLock::isThere() const { return leadsTo(file_, descriptor_); }

void syncFolder(const std::filesystem::path& folder) {
  const Closer in{openOrFail(folder, O_RDONLY | O_DIRECTORY)};
  if (::fsync(in.descriptor) != 0) fail(folder, "cannot sync");
}

InputFile::InputFile(const std::filesystem::path& file)
    : file_(file), descriptor_(openOrFail(file, O_RDONLY | O_NONBLOCK, "cannot read")) {
  struct stat status {};
  if (::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode)) {
    size_ = static_cast<std::uint64_t>(status.st_size);
    return;
  }
  ::close(descriptor_);
  failAsNoFile(file, "cannot read", status.st_mode);
}

InputFile::~InputFile() { ::close(descriptor_); }

std::string InputFile::read(std::uint64_t count) {
  std::string content;
  while (content.size() < count) {
    const std::size_t before = content.size();
    const std::uint64_t expected = size_ > done_ ? size_ - done_ : kBlock;
    content.resize(before + static_cast<std::size_t>(std::min(count - before, expected)));
    const ssize_t got = ::read(descriptor_, content.data() + before, content.size() - before);
    if (got < 0 && errno != EINTR) fail(file_, "cannot read");
    content.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    done_ += content.size() - before;
    if (got == 0) break;
  }
  return content;
}

std::string readFile(const std::filesystem::path& file, std::uint64_t most) {
  InputFile in(file);
  if (in.size() > most) {
    throw DiskError(file.string() + ": cannot read: it has " + std::to_string(in.size()) + " bytes, not " +
                        std::to_string(most) + " or fewer",
                    EFBIG);
  }
  return in.read(most);
}

std::uint32_t crc32Of(std::string_view content) {
  return static_cast<std::uint32_t>(
      ::crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<z_size_t>(content.size())));
}

AppendFile::AppendFile(const std::filesystem::path& file, std::uint64_t keep)
    : file_(file),
      descriptor_(openOrFail(file, O_WRONLY | O_CREAT | O_NONBLOCK | (keep == kNew ? O_EXCL : 0))),
      size_(keep == kNew ? 0 : keep) {
  ::fcntl(descriptor_, F_SETFL, 0);  // only to open a pipe did it matter
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) return;
  if (keep == kAll) size_ = static_cast<std::uint64_t>(status.st_size);
  if (::ftruncate(descriptor_, static_cast<off_t>(size_)) != 0 || ::lseek(descriptor_, 0, SEEK_END) < 0) {
    ::close(descriptor_);
    fail(file, "cannot truncate");
  }
}

AppendFile::~AppendFile() { ::close(descriptor_); }

void AppendFile::append(std::string_view content) {
  try {
    writeAll(file_, descriptor_, content);
    size_ += content.size();
  } catch (const std::runtime_error&) {
    // Half a record would hide all that come after it.
    if (::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) ::lseek(descriptor_, 0, SEEK_END);
    throw;
  }
}

bool AppendFile::isThere() const { return leadsTo(file_, descriptor_); }

void AppendFile::sync() {
  if (::fdatasync(descriptor_) != 0) fail(file_, "cannot sync");
}

}  // namespace slam
