// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

namespace slam {

/// Whether the kernel would send to the address of a udpm or mpudpm URL at all. liblcm prints a page to stderr at each
/// attempt without a route: it is to be asked only where there is one.
/// @return true for other URLs, and for what is no address, which liblcm refuses in its own words
bool hasMulticastRoute(const std::string& url);

}  // namespace slam
