// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "drivers/base/base_facts.hpp"

namespace slam {

/// The reference firmware: it sends STATE unasked, and takes SPEEDS in counts per second.
std::unique_ptr<BaseProtocol> makeFrameProtocol(const BaseProtocolConfig& config);

}  // namespace slam
