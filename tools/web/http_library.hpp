// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <httplib.h>
#undef _res  // of <resolv.h>, which cpp-httplib includes: Eigen has parameters of this name
