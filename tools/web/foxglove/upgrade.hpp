// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "tools/web/http_library.hpp"

namespace slam {

/// Whether a request asks for another protocol than HTTP on its connection.
bool isUpgrade(const httplib::Request& request);

/// The answer to the opening handshake of a WebSocket (RFC 6455, section 4.2.2) for Foxglove's protocol. A page of a
/// stranger may not open one, since browsers ask no permission for it: pages of this computer's own names and of
/// Foxglove itself may, and programs without a page.
/// @param isOwnHost whether a name is one of this computer's @return false, with the refusal in `response`
bool upgrade(const httplib::Request& request, httplib::Response& response,
             const std::function<bool(const std::string& host)>& isOwnHost);

/// Takes out of a 101 what cpp-httplib adds to each answer.
void finishUpgrade(httplib::Response& response);

/// Sec-WebSocket-Accept for a Sec-WebSocket-Key.
std::string acceptOf(std::string_view key);

}  // namespace slam
