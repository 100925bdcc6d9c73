// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/certificate.hpp"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <stdexcept>

#include "config/loader.hpp"
#include "store/durable_file.hpp"

namespace slam {
namespace {

constexpr long kLifetime = 820L * 24 * 3600;  // [s] Apple's devices trust none for longer than 825 days
constexpr long kRenewed = 30L * 24 * 3600;    // [s] before its end
constexpr long kBefore = 24L * 3600;          // [s] for a clock that is behind

template <typename T, auto Free>
struct Freed {
  void operator()(T* of) const { Free(of); }
};
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY, EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509, X509_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION, X509_EXTENSION_free>>;
using Memory = std::unique_ptr<BIO, Freed<BIO, BIO_free_all>>;
using File = std::unique_ptr<std::FILE, Freed<std::FILE, std::fclose>>;

[[noreturn]] void refuse(const std::string& key, const std::string& words) { throw ConfigError({key + ": " + words}); }

/// What OpenSSL has found last.
std::string opensslWords() {
  const char* words = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return words != nullptr ? words : "unknown";
}

/// @return nullptr where OpenSSL cannot read the value
Extension extensionOf(int id, const std::string& value) {
  Extension made(X509V3_EXT_conf_nid(nullptr, nullptr, id, value.c_str()));
  ERR_clear_error();
  return made;
}

Certificate makeCertificate(EVP_PKEY* key, const std::vector<std::string>& names) {
  Certificate made(X509_new());
  X509* certificate = made.get();
  std::array<unsigned char, 4> serial{};
  std::FILE* random = std::fopen("/dev/urandom", "rb");
  if (random != nullptr) {
    if (std::fread(serial.data(), 1, serial.size(), random) != serial.size()) serial[0] = 1;
    std::fclose(random);
  }
  ASN1_INTEGER_set(X509_get_serialNumber(certificate),
                   1 + (serial[0] | serial[1] << 8 | serial[2] << 16 | (serial[3] & 0x7F) << 24));
  X509_set_version(certificate, X509_VERSION_3);
  X509_gmtime_adj(X509_getm_notBefore(certificate), -kBefore);
  X509_gmtime_adj(X509_getm_notAfter(certificate), kLifetime);
  X509_set_pubkey(certificate, key);
  X509_NAME* name = X509_get_subject_name(certificate);
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8, reinterpret_cast<const unsigned char*>("slamd"), -1, -1, 0);
  X509_set_issuer_name(certificate, name);
  std::string list;
  for (const std::string& one : names) {
    std::array<unsigned char, 16> address{};
    const bool is_address =
        inet_pton(AF_INET, one.c_str(), address.data()) == 1 || inet_pton(AF_INET6, one.c_str(), address.data()) == 1;
    const std::string entry = (is_address ? "IP:" : "DNS:") + one;
    if (extensionOf(NID_subject_alt_name, entry)) list += (list.empty() ? "" : ",") + entry;
  }
  if (!list.empty()) X509_add_ext(certificate, extensionOf(NID_subject_alt_name, list).get(), -1);
  X509_add_ext(certificate, extensionOf(NID_basic_constraints, "critical,CA:FALSE").get(), -1);
  X509_add_ext(certificate, extensionOf(NID_ext_key_usage, "serverAuth").get(), -1);
  X509_sign(certificate, key, EVP_sha256());
  return made;
}

/// @param write in PEM; returns 1 where it could
void writeFile(const std::string& key, const std::string& path, mode_t rights, const auto& write) {
  try {
    Replacement next(path, ".part");
    const Memory text(BIO_new(BIO_s_mem()));
    if (!text || write(text.get()) != 1) throw std::runtime_error(opensslWords());
    char* begin = nullptr;
    const auto size = static_cast<std::size_t>(BIO_get_mem_data(text.get(), &begin));
    writeDurably(next.draft(), {begin, size}, rights);
    std::filesystem::permissions(next.draft(), std::filesystem::perms(rights));  // whatever the umask is
    next.putInPlace();
  } catch (const std::runtime_error& error) {
    refuse(key,
           std::string("cannot write: ") + error.what() + "; set web.certificate and web.key to files of your own");
  }
}

void makeOwn(const std::string& certificate_file, const std::string& key_file, const std::vector<std::string>& names) {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate = makeCertificate(key.get(), names);
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(key_file).parent_path(), error);  // the next call finds it
  writeFile("web.key", key_file, 0600,
            [&](BIO* out) { return PEM_write_bio_PrivateKey(out, key.get(), nullptr, nullptr, 0, nullptr, nullptr); });
  writeFile("web.certificate", certificate_file, 0644,
            [&](BIO* out) { return PEM_write_bio_X509(out, certificate.get()); });
}

/// @return nullptr where there is none in the file
Certificate certificateIn(const std::string& path) {
  const File file(std::fopen(path.c_str(), "re"));
  if (!file) refuse("web.certificate", "cannot read " + path + ": " + std::strerror(errno));
  return Certificate(PEM_read_X509(file.get(), nullptr, nullptr, nullptr));
}

/// Whether it is there, and valid for a while yet.
bool isGood(const std::string& path) {
  if (!std::filesystem::exists(path)) return false;
  const Certificate certificate = certificateIn(path);
  std::time_t then = std::time(nullptr) + kRenewed;
  return certificate && X509_cmp_time(X509_get0_notAfter(certificate.get()), &then) > 0;
}

}  // namespace

void SslContextDeleter::operator()(SSL_CTX* context) const { SSL_CTX_free(context); }

std::string fingerprintOf(const std::string& path) {
  const Certificate certificate = certificateIn(path);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (!certificate || X509_digest(certificate.get(), EVP_sha256(), digest.data(), &size) != 1)
    refuse("web.certificate", path + " is no certificate in PEM: " + opensslWords());
  std::string text;
  for (unsigned i = 0; i < size; ++i) {
    std::array<char, 4> digits{};
    std::snprintf(digits.data(), digits.size(), i > 0 ? ":%02X" : "%02X", static_cast<unsigned>(digest[i]));
    text += digits.data();
  }
  return text;
}

std::string stateFolder() {
  const char* given = std::getenv("STATE_DIRECTORY");  // of systemd
  return given != nullptr && *given != '\0' ? given : "/var/lib/slamd-web";
}

std::string certificateFileOf(const WebConfig& web, const std::string& folder) {
  return web.certificate.empty() ? folder + "/certificate.pem" : web.certificate;
}

TlsContext tlsContextOf(const WebConfig& web, const std::string& folder, const std::vector<std::string>& names) {
  TlsContext made;
  const std::string certificate_file = certificateFileOf(web, folder);
  const std::string key_file = web.key.empty() ? folder + "/key.pem" : web.key;
  const bool is_own = web.certificate.empty() && web.key.empty();
  if (is_own && !isGood(certificate_file)) {
    makeOwn(certificate_file, key_file, names);
    made.is_new = true;
  }
  made.fingerprint = fingerprintOf(certificate_file);
  made.context.reset(SSL_CTX_new(TLS_server_method()));
  SSL_CTX* context = made.context.get();
  if (context == nullptr) throw std::bad_alloc();
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  if (SSL_CTX_use_certificate_chain_file(context, certificate_file.c_str()) != 1)
    refuse("web.certificate", certificate_file + ": " + opensslWords());
  if (SSL_CTX_use_PrivateKey_file(context, key_file.c_str(), SSL_FILETYPE_PEM) != 1)
    refuse("web.key", "cannot read " + key_file + " as a key in PEM: " + opensslWords() +
                          "; slam-web runs as slamd-web, which must be able to read it");
  if (SSL_CTX_check_private_key(context) != 1) refuse("web.key", key_file + " is not the key of web.certificate");
  return made;
}

}  // namespace slam
