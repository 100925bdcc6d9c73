// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>

#include "config/config.hpp"

namespace slam {

/// Whether no other computer reaches who listens there.
bool isThisComputerAlone(const std::string& address);

/// Address of slam-web, as configured.
std::string webAddressOf(const WebConfig& web);

/// A text as a QR code for terminals: two rows of its squares in a line, by half blocks, with a rim of 4 light squares.
/// @throws std::runtime_error where the text is too long for one
std::string qrCodeOf(const std::string& text);

/// Prints that, in colours where it is a terminal.
void printQrCode(const std::string& text);

/// Prints the address and the fingerprint of its certificate.
/// @param qr also a QR code of the address, with the token behind # where the page needs one
/// @throws ConfigError where the token cannot be read
void printWebAddress(const WebConfig& web, bool qr);

}  // namespace slam
