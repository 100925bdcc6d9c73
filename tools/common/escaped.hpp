// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace slam {

/// Text that stands for itself in XML and HTML, between tags and in quotes.
std::string escaped(const std::string& text);

}  // namespace slam
