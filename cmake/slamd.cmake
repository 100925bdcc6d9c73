# SPDX-License-Identifier: BSD-3-Clause
# One function per kind of target, so that warnings, sanitizers and include roots are set in one place.

add_library(slamd_options INTERFACE)
target_compile_features(slamd_options INTERFACE cxx_std_20)
target_include_directories(slamd_options INTERFACE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/daemon)
# -ffp-contract=off: the same source gives the same bits with and without fused multiply-add.
target_compile_options(slamd_options INTERFACE -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion
                                               -Wnon-virtual-dtor -ffp-contract=off -fno-math-errno
                                               -ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)
# Eigen asks for fused multiply-add by name where aarch64 says that it has it: without, it computes as on amd64.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64)
  target_compile_options(slamd_options INTERFACE -U__ARM_FEATURE_FMA)
endif()
if(SLAMD_WERROR)
  target_compile_options(slamd_options INTERFACE -Werror)
endif()
if(SLAMD_SANITIZE)
  # With sanitizers GCC 12 sees uninitialised members in std::regex and std::variant that are not (GCC bug 105562).
  target_compile_options(slamd_options INTERFACE -fsanitize=${SLAMD_SANITIZE} -fno-sanitize-recover=all
                                                 $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(slamd_options INTERFACE -fsanitize=${SLAMD_SANITIZE})
  # What AddressSanitizer finds too, at a third of GCC's time; the fuzz targets, by clang, keep all checks.
  if(SLAMD_SANITIZE MATCHES undefined AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(slamd_options INTERFACE -fno-sanitize=null,alignment,object-size)
  endif()
  # Parsed once. Release builds have none, and so find each include that is missing.
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/slam_headers.cpp CONTENT "")
  add_library(slam_headers STATIC ${CMAKE_BINARY_DIR}/slam_headers.cpp)
  target_link_libraries(slam_headers PRIVATE slamd_options Eigen3::Eigen)
  target_precompile_headers(slam_headers PRIVATE
    <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <cstdint> <cstdio> <deque> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <mutex> <numbers> <optional> <random> <span> <sstream> <stdexcept> <string>
    <string_view> <utility> <vector> <Eigen/Core> <Eigen/Geometry>)
endif()

# Of what is inlined from precompiled headers GCC 12 forgets that it is the system's, and warns of std::string's joins.
function(slam_parsed_once name)
  if(TARGET slam_headers)
    target_precompile_headers(${name} REUSE_FROM slam_headers)
    target_compile_options(${name} PRIVATE -Wno-array-bounds
      "$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread>")
  endif()
endfunction()

# For whole builds of tests, each of which has a namespace of its own: what eight sources include and instantiate alike is
# compiled once.
function(slam_compiled_in_eights name)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  # Of so much at once GCC 12 sees members uninitialised and pointers dangling that are not; builds without eights keep
  # these warnings.
  target_compile_options(${name} PRIVATE
    "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-dangling-pointer>")
endfunction()

# slam_library(NAME SOURCES a.cpp ... LINKS lib ...): a static library of the current folder.
function(slam_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC slamd_options ${ARG_LINKS})
  slam_parsed_once(${name})
endfunction()

# For what runs once or is a test: -O3 would cost more than it gains. A packager's flags stay as they are.
set(SLAMD_LITTLE_OPTIMISATION)
if(CMAKE_CXX_FLAGS_RELEASE STREQUAL SLAMD_RELEASE_FLAGS)
  set(SLAMD_LITTLE_OPTIMISATION $<$<CONFIG:Release>:-O1>)
endif()

# slam_command_line(a.cpp ...): what reads a command line; CLI11's headers alone cost 4 s a file at -O3.
function(slam_command_line)
  set_source_files_properties(${ARGV} PROPERTIES COMPILE_OPTIONS "${SLAMD_LITTLE_OPTIMISATION}")
endfunction()

# slam_program(NAME SOURCES a.cpp ... LINKS lib ...): an executable in build/<preset>/bin.
function(slam_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE slamd_options ${ARG_LINKS})
  target_compile_definitions(${name} PRIVATE SLAMD_VERSION="${PROJECT_VERSION}")
  slam_parsed_once(${name})
  slam_command_line(main.cpp)
  install(TARGETS ${name})
endfunction()
