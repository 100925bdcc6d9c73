// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/logs/log_folder.hpp"

#include <algorithm>
#include <dirent.h>
#include <fcntl.h>
#include <linux/openat2.h>
#include <memory>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace slam {

OpenFile::~OpenFile() { ::close(descriptor_); }

std::size_t OpenFile::read(std::uint64_t offset, char* bytes, std::size_t size) const {
  const ssize_t got = ::pread(descriptor_, bytes, size, static_cast<off_t>(offset));
  return static_cast<std::size_t>(std::max<ssize_t>(got, 0));
}

int LogFolder::openBeneath(const std::vector<std::string>& parts, int flags) const {
  if (root_.empty()) return -1;
  const int root = ::open(root_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (root < 0) return -1;
  std::string path = ".";
  for (const std::string& part : parts) path += "/" + part;
  open_how how{};
  how.flags =
      static_cast<std::uint64_t>(flags | O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);  // a pipe must not block
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
  const int opened = static_cast<int>(::syscall(SYS_openat2, root, path.c_str(), &how, sizeof how));
  ::close(root);
  return opened;
}

std::optional<std::vector<LogFolder::Entry>> LogFolder::list(const std::vector<std::string>& parts) const {
  const int folder = openBeneath(parts, O_DIRECTORY);
  if (folder < 0) return std::nullopt;
  const std::unique_ptr<DIR, int (*)(DIR*)> stream(::fdopendir(folder), &::closedir);
  if (!stream) {
    ::close(folder);
    return std::nullopt;
  }
  std::vector<Entry> entries;
  while (const dirent* entry = ::readdir(stream.get())) {
    if (entry->d_name[0] == '.' || entries.size() >= kMostEntries) continue;
    struct stat status {};
    if (::fstatat(folder, entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0) continue;
    const bool is_folder = S_ISDIR(status.st_mode);
    if (!is_folder && !S_ISREG(status.st_mode)) continue;
    entries.push_back({entry->d_name, is_folder, static_cast<std::uint64_t>(status.st_size)});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.name > b.name; });
  return entries;
}

std::shared_ptr<OpenFile> LogFolder::open(const std::vector<std::string>& parts) const {
  const int file = openBeneath(parts, 0);
  if (file < 0) return nullptr;
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file);
    return nullptr;
  }
  return std::make_shared<OpenFile>(file, static_cast<std::uint64_t>(status.st_size), status.st_mtime);
}

}  // namespace slam
