// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "config/config.hpp"

using SSL_CTX = struct ssl_ctx_st;

namespace slam {

struct SslContextDeleter {
  void operator()(SSL_CTX* context) const;
};
/// What TLS needs of OpenSSL: certificate and key.
struct TlsContext {
  std::unique_ptr<SSL_CTX, SslContextDeleter> context;
  std::string fingerprint;  ///< SHA-256 of the certificate, as browsers show it
  bool is_new = false;      ///< it was made just now
};

/// Where the certificate lies: web.certificate, or else one of this computer's own.
/// @param folder of the own one
std::string certificateFileOf(const WebConfig& web, const std::string& folder);
/// Of slam-web's own certificate: $STATE_DIRECTORY, or the service's.
std::string stateFolder();

/// The certificate of web.certificate with the key of web.key. Where both are empty, one of this computer's own, which
/// is made where it is not there yet, or ends within 30 days: for 820 days, with its key for nobody else to read.
/// @param names that the page is opened by @throws ConfigError, with the fix
TlsContext tlsContextOf(const WebConfig& web, const std::string& folder, const std::vector<std::string>& names);

/// SHA-256 of the certificate in a file, in hexadecimal digits parted by colons. @throws ConfigError
std::string fingerprintOf(const std::string& file);

}  // namespace slam
