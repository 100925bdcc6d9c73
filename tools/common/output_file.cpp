// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace slam {

OutputFile::OutputFile(const std::filesystem::path& file) : file_(file), out_(file) {
  if (!out_) throw std::runtime_error(file.string() + ": cannot write: " + std::strerror(errno));
}

void OutputFile::close() {
  out_.close();
  if (!out_) throw std::runtime_error(file_.string() + ": cannot write all of it: " + std::strerror(errno));
}

}  // namespace slam
