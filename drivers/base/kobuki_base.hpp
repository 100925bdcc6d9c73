// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/base/base_facts.hpp"

namespace slam {

/// Kobuki: it sends unasked, with stamps of its own; nothing is asked.
std::unique_ptr<BaseProtocol> makeKobukiProtocol(const BaseProtocolConfig& config);

}  // namespace slam
