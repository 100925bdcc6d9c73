// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string_view>

namespace slam {

/// A file of the folder page/, compiled in.
struct PageFile {
  std::string_view path;  ///< as in a URL
  const char* type;       ///< MIME
  std::string_view content;
};

/// @return nullptr for any other path
const PageFile* findPageFile(std::string_view path);

}  // namespace slam
