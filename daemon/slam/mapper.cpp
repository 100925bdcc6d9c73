// SPDX-License-Identifier: BSD-3-Clause
#include "slam/mapper.hpp"
