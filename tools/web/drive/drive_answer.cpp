// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/drive/drive_answer.hpp"

#include <nlohmann/json.hpp>

#include "bus/problem_message.hpp"
#include "problems/answer.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/web/access/token_gate.hpp"

namespace slam {
namespace {

constexpr const char* kJson = "application/json";

}  // namespace

bool isJson(const httplib::Request& request, httplib::Response& response) {
  if (request.get_header_value("Content-Type").starts_with(kJson)) return true;
  refuse(response, 415, "a command is application/json");
  return false;
}

void answerWith(httplib::Response& response, bool accepted, const std::string& message,
                const std::vector<problem_t>& parts) {
  auto rows = nlohmann::json::array();
  for (const problem_t& part : parts) rows.push_back(problemJson(part));
  response.status = accepted ? 200 : 409;
  response.set_content(textOf({{"accepted", accepted}, {"message", message}, {"parts", std::move(rows)}}), kJson);
}

void answerDrive(const httplib::Request& request, httplib::Response& response, const Driver& driver) {
  std::string problem;
  const auto drive = driveRequestOf(request.body, problem);
  if (!drive) return refuse(response, 400, problem);
  try {
    const Problem refusal = driver(*drive);
    if (!refusal) return answerWith(response, true, "sent", {});
    answerWith(response, false, refusal.words(), {toMessage("drive", refusal, false)});
  } catch (const CommandRefused& refused) {
    refuse(response, 502, answerOf(refused));
  } catch (const std::runtime_error& error) {
    refuse(response, 502, error.what());
  }
}

}  // namespace slam
