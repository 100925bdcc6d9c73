// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/web/setup_page.hpp"

#include <exception>
#include <iostream>

#include "tools/slamctl/setup/web/setup_server.hpp"
#include "tools/slamctl/web_address.hpp"
#include "tools/web/access/certificate.hpp"
#include "tools/web/access/token_gate.hpp"
#include "tools/web/request_guard.hpp"

namespace slam {
namespace {

/// The address by name, and by number for phones that find no names of this network.
void printAddresses(WebConfig web, bool qr) {
  const std::string by_name = webAddressOf(web), secret = "#token=" + web.token;
  std::cout << "Open this on a phone or a computer in the robot's network, and go on there:\n  " << by_name << secret
            << "\n";
  for (const std::string& name : ownNames(web.address)) {
    const bool is_v4 = name.find_first_not_of("0123456789.") == std::string::npos;
    if (!is_v4 || name.starts_with("127.")) continue;
    web.address = name;
    std::cout << "  " << webAddressOf(web) << secret << "\n";
  }
  std::cout << std::flush;
  if (qr) printQrCode(by_name + secret);
}

}  // namespace

bool setUpOnPage(WebConfig web, const std::filesystem::path& folder, bool qr,
                 const std::function<bool(Console&)>& setUp) {
  web.address = "0.0.0.0";
  web.commands = true;
  web.token = drawnSecret();
  // Not slam-web's certificate, whose key root would take from it.
  TlsContext tls = web.tls ? tlsContextOf(web, folder.string(), ownNames(web.address)) : TlsContext();
  const std::string fingerprint = tls.fingerprint;
  WebConsole console(std::cout);
  const SetupServer server(web, console, {}, std::move(tls));
  web.port = server.port();
  printAddresses(web, qr);
  if (web.tls) std::cout << "SHA-256 fingerprint of its certificate: " << fingerprint << "\n" << std::flush;
  try {
    return setUp(console);
  } catch (const std::exception& error) {
    console.fail(error.what());
    throw;
  }
}

}  // namespace slam
