# Headers that nearly every file needs, compiled once: they took more than half of the time of a build.
# Sources still include what they use: -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON compiles without.
if(NOT EXISTS ${CMAKE_BINARY_DIR}/generated/precompiled.cpp)  # a newer one would compile everything again
  file(WRITE ${CMAKE_BINARY_DIR}/generated/precompiled.cpp "")
endif()

function(gabion_precompile name)
  cmake_parse_arguments(arg "" "" "LIBS;HEADERS" ${ARGN})
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/generated/precompiled.cpp)
  target_link_libraries(${name} PRIVATE gabion_options fmt::fmt spdlog::spdlog nlohmann_json::nlohmann_json ${arg_LIBS})
  target_precompile_headers(${name} PRIVATE
    <algorithm> <array> <cmath> <cstdint> <functional> <map> <memory> <optional> <set> <span> <string> <vector>
    <fmt/format.h> <fmt/ranges.h> <nlohmann/json.hpp> ${arg_HEADERS})
endfunction()

set(gabion_vectors "") # of simd/lanes.hpp, which reaches half of the files
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  set(gabion_vectors <immintrin.h>)
endif()
gabion_precompile(gabion_precompiled LIBS Eigen3::Eigen HEADERS <Eigen/Dense> ${gabion_vectors})
# Part of a shared library too: position-independent, without Eigen.
gabion_precompile(gabion_precompiled_shared)
set_target_properties(gabion_precompiled_shared PROPERTIES POSITION_INDEPENDENT_CODE ON)
if(GABION_BUILD_TESTS)
  gabion_precompile(gabion_precompiled_tests LIBS Eigen3::Eigen GTest::gtest
                    HEADERS <Eigen/Dense> ${gabion_vectors} <gtest/gtest.h>)
  target_compile_options(gabion_precompiled_tests PRIVATE ${gabion_test_options})
endif()

# Let every C++ target of a folder and of those below use them.
function(gabion_use_precompiled_headers folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(shared ${target} POSITION_INDEPENDENT_CODE)
    set(headers gabion_precompiled)
    if(folder MATCHES "^${CMAKE_SOURCE_DIR}/tests")
      set(headers gabion_precompiled_tests)
    elseif(shared OR type STREQUAL "SHARED_LIBRARY")
      set(headers gabion_precompiled_shared)
    endif()
    if(type MATCHES "STATIC|SHARED|OBJECT|EXECUTABLE" AND NOT target MATCHES "^gabion_precompiled")
      target_precompile_headers(${target} REUSE_FROM ${headers})
    endif()
  endforeach()
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below ${folders})
    gabion_use_precompiled_headers(${below})
  endforeach()
endfunction()
