// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

struct archive;

namespace slam {

/// Writes a zip file from its begin to its end, so that it can be sent while it is made. By libarchive.
class ZipWriter {
 public:
  /// Takes the next bytes of the file. @return false where it can take no more
  using Sink = std::function<bool(std::string_view bytes)>;
  enum class Method { kDeflate, kStore };

  /// @throws std::runtime_error as all functions here: where the sink can take no more
  explicit ZipWriter(Sink sink, Method method = Method::kDeflate);
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  /// Begins an entry, and ends the one before. @param modified [s since the epoch]
  void begin(const std::string& name, std::time_t modified);
  /// The next part of the entry's content.
  void write(std::string_view content);
  void close();

 private:
  void check(std::ptrdiff_t result) const;

  Sink sink_;
  bool is_full_ = false;  // the sink takes no more
  std::unique_ptr<archive, int (*)(archive*)> archive_;
};

}  // namespace slam
