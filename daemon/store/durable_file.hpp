// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/types.h>

namespace slam {

/// A disk refuses something.
struct DiskError : std::runtime_error {
  DiskError(const std::string& words, int error) : std::runtime_error(words), code(error) {}
  int code;  ///< errno
};

/// Writes a new file and waits until it is on the disk.
/// @param rights of a file that is not there yet, less what the umask takes
/// @throws std::runtime_error naming file and reason
void writeDurably(const std::filesystem::path& file, std::string_view content, mode_t rights = 0644);

/// Waits until a folder's entries are on the disk. @throws std::runtime_error
void syncFolder(const std::filesystem::path& folder);

/// Takes the place of a file whole or not at all: it is written beside it, as draft(), and then renamed.
class Replacement {
 public:
  /// @param ending of the draft, behind the file's name; what has that name is removed
  explicit Replacement(std::filesystem::path file, const std::string& ending = ".new");
  ~Replacement();  ///< removes a draft that was not put in place
  Replacement(const Replacement&) = delete;
  Replacement& operator=(const Replacement&) = delete;

  const std::filesystem::path& draft() const { return draft_; }
  /// Waits until the folder has it. @pre the draft is on the disk @throws DiskError
  void putInPlace();

 private:
  std::filesystem::path file_, draft_;
};

/// A file that is read once, from its begin to its end. Whatever has its name, opening and reading it waits for nobody.
class InputFile {
 public:
  /// @throws DiskError naming file and reason, also for what is no file: a folder, a pipe, a socket, a device
  explicit InputFile(const std::filesystem::path& file);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::uint64_t size() const { return size_; }  ///< [bytes] by its folder
  /// The next bytes; fewer at the end. Takes memory for those that are there. @throws DiskError
  std::string read(std::uint64_t count);

 private:
  std::filesystem::path file_;
  int descriptor_;
  std::uint64_t size_ = 0, done_ = 0;
};

/// The whole of a file. @param most [bytes] of a larger one nothing is read
/// @throws DiskError naming file and reason
std::string readFile(const std::filesystem::path& file, std::uint64_t most);

/// CRC-32 as of zlib.
std::uint32_t crc32Of(std::string_view content);

/// A folder that another program writes to.
struct FolderLocked : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Keeps a folder to one program at a time, as long as it lives; a program that dies lets go of it.
class FolderLock {
 public:
  /// @throws FolderLocked where another one has it, also within this program
  /// @throws std::runtime_error where the folder cannot be written to
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// @return false when the folder was removed, or its disk is no longer the one mounted there
  bool isThere() const;

 private:
  std::filesystem::path file_;
  int descriptor_;
};

/// A file that only grows. A pipe or a device will do.
class AppendFile {
 public:
  static constexpr std::uint64_t kAll = UINT64_MAX, kNew = UINT64_MAX - 1;
  /// Opens it, new or to go on behind `keep` bytes; what lies behind them is cut off. kNew refuses a file that is
  /// there.
  /// @throws std::runtime_error, also for a pipe that nobody reads
  AppendFile(const std::filesystem::path& file, std::uint64_t keep);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// All or nothing, as far as the file system lets it. @throws std::runtime_error, e.g. when the disk is full
  void append(std::string_view content);
  /// Waits until all is on the disk. @throws std::runtime_error
  void sync();
  /// @return false when its name leads elsewhere by now: it was removed, or its disk is no longer the one mounted there
  bool isThere() const;
  std::uint64_t size() const { return size_; }  ///< [bytes]
  const std::filesystem::path& path() const { return file_; }

 private:
  std::filesystem::path file_;
  int descriptor_;
  std::uint64_t size_;
};

}  // namespace slam
