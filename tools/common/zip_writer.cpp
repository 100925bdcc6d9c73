// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/zip_writer.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <cerrno>
#include <stdexcept>

namespace slam {

ZipWriter::ZipWriter(Sink sink, Method method)
    : sink_(std::move(sink)), archive_(archive_write_new(), &archive_write_free) {
  const auto take = [](archive* zip, void* self, const void* bytes, std::size_t size) -> la_ssize_t {
    if (static_cast<ZipWriter*>(self)->sink_({static_cast<const char*>(bytes), size}))
      return static_cast<la_ssize_t>(size);
    archive_set_error(zip, ENOSPC, "it cannot be written");
    return -1;
  };
  check(archive_write_set_format_zip(archive_.get()));
  check(method == Method::kStore ? archive_write_zip_set_compression_store(archive_.get())
                                 : archive_write_zip_set_compression_deflate(archive_.get()));
  check(archive_write_set_bytes_per_block(archive_.get(), 1 << 16));
  check(archive_write_set_bytes_in_last_block(archive_.get(), 1));  // no padding
  check(archive_write_open(archive_.get(), this, nullptr, take, nullptr));
}

ZipWriter::~ZipWriter() { archive_write_fail(archive_.get()); }  // what was not closed is not written to its end

void ZipWriter::begin(const std::string& name, std::time_t modified) {
  const std::unique_ptr<archive_entry, void (*)(archive_entry*)> entry(archive_entry_new(), &archive_entry_free);
  archive_entry_set_pathname_utf8(entry.get(), name.c_str());
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), 0644);
  archive_entry_set_mtime(entry.get(), modified, 0);
  check(archive_write_header(archive_.get(), entry.get()));
}

void ZipWriter::write(std::string_view content) {
  check(archive_write_data(archive_.get(), content.data(), content.size()));
}

void ZipWriter::close() { check(archive_write_close(archive_.get())); }

void ZipWriter::check(std::ptrdiff_t result) const {
  if (result >= ARCHIVE_OK) return;
  const char* reason = archive_error_string(archive_.get());
  throw std::runtime_error(reason != nullptr ? reason : "the zip file cannot be written");
}

}  // namespace slam
