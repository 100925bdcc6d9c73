// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>

#include "config/config.hpp"
#include "tools/slamctl/setup/console.hpp"

namespace slam {

/// Has a set-up asked and shown on a page, whose address it prints, with a token that is drawn for this time.
/// @param web whose port, and whether https @param folder for a certificate of this time @param qr prints a QR code,
/// too
/// @param setUp gets the console @return what that does
/// @throws what that does, once a page has shown it; std::runtime_error where it cannot listen
bool setUpOnPage(WebConfig web, const std::filesystem::path& folder, bool qr,
                 const std::function<bool(Console&)>& setUp);

}  // namespace slam
