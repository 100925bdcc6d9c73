// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/zip_writer.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <stdexcept>

namespace slam {

ZipWriter::ZipWriter(Sink sink, Method method)
    : sink_(std::move(sink)), archive_(archive_write_new(), &archive_write_free) {
  const auto take = [](archive*, void* self, const void* bytes, std::size_t size) -> la_ssize_t {
    auto& zip = *static_cast<ZipWriter*>(self);
    zip.is_full_ = zip.is_full_ || !zip.sink_({static_cast<const char*>(bytes), size});
    return static_cast<la_ssize_t>(size);  // after an error libarchive does not free what it has
  };
  check(archive_write_set_format_zip(archive_.get()));
  check(method == Method::kStore ? archive_write_zip_set_compression_store(archive_.get())
                                 : archive_write_zip_set_compression_deflate(archive_.get()));
  check(archive_write_set_bytes_per_block(archive_.get(), 1 << 16));
  check(archive_write_set_bytes_in_last_block(archive_.get(), 1));  // no padding
  check(archive_write_open(archive_.get(), this, nullptr, take, nullptr));
}

ZipWriter::~ZipWriter() { is_full_ = true; }  // what was not closed is not written to its end

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
  if (is_full_) throw std::runtime_error("the zip file cannot be written");
  if (result < ARCHIVE_OK) throw std::runtime_error(archive_error_string(archive_.get()));
}

}  // namespace slam
