// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/web_address.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <qrencode.h>
#include <stdexcept>
#include <unistd.h>

#include "config/loader.hpp"
#include "tools/web/access/certificate.hpp"
#include "tools/web/access/token_file.hpp"

namespace slam {

bool isThisComputerAlone(const std::string& address) { return address == "::1" || address.starts_with("127."); }

std::string webAddressOf(const WebConfig& web) {
  const bool is_any = web.address == "0.0.0.0" || web.address == "::";
  const bool is_v6 = !is_any && web.address.find(':') != std::string::npos;
  std::array<char, 256> name{};
  if (is_any) ::gethostname(name.data(), name.size() - 1);
  return std::string(web.tls ? "https://" : "http://") +
         (is_any  ? name.data() + std::string(".local")
          : is_v6 ? "[" + web.address + "]"
                  : web.address) +
         ":" + std::to_string(web.port) + "/";
}

std::string qrCodeOf(const std::string& text) {
  constexpr int kRim = 4;  // squares
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeString(text.c_str(), 0, QR_ECLEVEL_M, QR_MODE_8, 1), QRcode_free);
  if (!code) throw std::runtime_error("no QR code holds this address");
  const auto isDark = [&](int row, int column) {
    const bool inside = row >= 0 && row < code->width && column >= 0 && column < code->width;
    return inside && (code->data[row * code->width + column] & 1) != 0;
  };
  std::string out;
  for (int row = -kRim; row < code->width + kRim; row += 2) {
    for (int column = -kRim; column < code->width + kRim; ++column) {
      const bool upper = isDark(row, column), lower = isDark(row + 1, column);
      out += upper && lower ? "█" : upper ? "▀" : lower ? "▄" : " ";
    }
    out += '\n';
  }
  return out;
}

void printWebAddress(const WebConfig& web, bool qr) {
  const std::string file = certificateFileOf(web, stateFolder()), address = webAddressOf(web);
  const bool is_there = web.tls && std::filesystem::exists(file);
  std::printf("%s\n", address.c_str());
  if (is_there) std::printf("SHA-256 fingerprint of its certificate: %s\n", fingerprintOf(file).c_str());
  if (web.tls && !is_there) std::printf("its certificate is made when slam-web starts first\n");
  if (!qr) return;
  if (isThisComputerAlone(web.address))
    throw ConfigError({"web.address is " + web.address + ", which no phone reaches; set web.address = \"0.0.0.0\""});
  const std::string token = tokenOf(web);
  printQrCode(address + (token.empty() ? "" : "#token=" + token));
}

void printQrCode(const std::string& text) {
  const std::string code = qrCodeOf(text);
  // Black on white whatever the terminal's colours are: cameras want it so.
  const bool is_terminal = ::isatty(STDOUT_FILENO) != 0;
  for (std::size_t begin = 0, end = 0; begin < code.size(); begin = end + 1) {
    end = code.find('\n', begin);
    const std::string line = code.substr(begin, end - begin);
    std::printf(is_terminal ? "\033[38;5;16m\033[48;5;231m%s\033[0m\n" : "%s\n", line.c_str());
  }
}

}  // namespace slam
