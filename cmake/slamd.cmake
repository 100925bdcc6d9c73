# SPDX-License-Identifier: BSD-3-Clause
# One function per kind of target, so that warnings, sanitizers and include roots are set in one place.

add_library(slamd_options INTERFACE)
target_compile_features(slamd_options INTERFACE cxx_std_20)
target_include_directories(slamd_options INTERFACE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/daemon)
# -ffp-contract=off: the same source gives the same bits with and without fused multiply-add.
target_compile_options(slamd_options INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
                                               -Wnon-virtual-dtor -ffp-contract=off -fno-math-errno
                                               -ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)
if(SLAMD_WERROR)
  target_compile_options(slamd_options INTERFACE -Werror)
endif()
if(SLAMD_SANITIZE)
  # With sanitizers GCC 12 sees uninitialised members in std::regex and std::variant that are not (GCC bug 105562).
  target_compile_options(slamd_options INTERFACE -fsanitize=${SLAMD_SANITIZE} -fno-sanitize-recover=all
                                                 $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(slamd_options INTERFACE -fsanitize=${SLAMD_SANITIZE})
endif()

# slam_library(NAME SOURCES a.cpp ... LINKS lib ...): a static library of the current folder.
function(slam_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC slamd_options ${ARG_LINKS})
endfunction()

# slam_program(NAME SOURCES a.cpp ... LINKS lib ...): an executable in build/<preset>/bin.
function(slam_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE slamd_options ${ARG_LINKS})
  target_compile_definitions(${name} PRIVATE SLAMD_VERSION="${PROJECT_VERSION}")
  install(TARGETS ${name})
endfunction()
