// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>
#include <slam/problem_t.hpp>
#include <string>
#include <vector>

#include "tools/web/drive/drive_relay.hpp"
#include "tools/web/http_library.hpp"

namespace slam {

/// Drives the base. @return none, or why not @throws std::runtime_error where nothing was sent
using Driver = std::function<Problem(const DriveRequest& request)>;

/// Whether a request brings what a page's script sends, and no form of another page can.
/// @return false, with the refusal in `response`
bool isJson(const httplib::Request& request, httplib::Response& response);
/// What was done, or why not, in words and as the rows that they are made of.
void answerWith(httplib::Response& response, bool accepted, const std::string& message,
                const std::vector<problem_t>& parts);
/// Answers to a request of a speed.
void answerDrive(const httplib::Request& request, httplib::Response& response, const Driver& driver);

}  // namespace slam
