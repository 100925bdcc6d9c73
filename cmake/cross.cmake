# SPDX-License-Identifier: BSD-3-Clause
# For another processor: SLAMD_TRIPLET names Debian's cross compiler, SLAMD_SYSROOT is a folder with that processor's
# packages, which tools/sysroot makes. Both come from the environment: CMake reads this file anew for each of its trials.
set(CMAKE_SYSTEM_NAME Linux)
string(REGEX REPLACE "-.*" "" CMAKE_SYSTEM_PROCESSOR "$ENV{SLAMD_TRIPLET}")
set(CMAKE_CXX_COMPILER $ENV{SLAMD_TRIPLET}-g++)
set(CMAKE_SYSROOT $ENV{SLAMD_SYSROOT})
set(CMAKE_LIBRARY_ARCHITECTURE $ENV{SLAMD_TRIPLET})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${CMAKE_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${CMAKE_SYSROOT}/usr/lib/$ENV{SLAMD_TRIPLET}/pkgconfig:${CMAKE_SYSROOT}/usr/share/pkgconfig)
