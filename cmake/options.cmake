# Language level, warnings, architecture and sanitizers of every target: link gabion_options.
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")

find_program(GABION_CCACHE ccache)
if(GABION_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${GABION_CCACHE})
endif()

add_library(gabion_options INTERFACE)
target_include_directories(gabion_options INTERFACE ${CMAKE_SOURCE_DIR} ${CMAKE_BINARY_DIR}/generated)
# Eigen's own vector code loses on 2x2 and 3x3 tensors that are filled by components (12 % of a soil step).
target_compile_definitions(gabion_options INTERFACE EIGEN_DONT_VECTORIZE)
# MPI's C face only: its header brings thousands of lines of a C++ one that nobody calls.
target_compile_definitions(gabion_options INTERFACE OMPI_SKIP_MPICXX)
target_compile_options(gabion_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow)
# GCC collects its garbage later, which changes no code: 8 % of the time of a build, for at most 1 GB a file.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(gabion_options INTERFACE --param=ggc-min-expand=200 --param=ggc-min-heapsize=1000000)
endif()
if(GABION_WARNINGS_AS_ERRORS)
  target_compile_options(gabion_options INTERFACE -Werror)
endif()
if(GABION_SANITIZERS)
  target_compile_options(gabion_options INTERFACE -fsanitize=${GABION_SANITIZERS} -fno-omit-frame-pointer)
  target_link_options(gabion_options INTERFACE -fsanitize=${GABION_SANITIZERS})
  if(GABION_UNCHECKED)
    target_compile_options(gabion_options INTERFACE -fno-sanitize=${GABION_UNCHECKED})
  endif()
endif()

# Tests set scenes up and compare: their own code need not be fast, and compiles in a third of the time.
set(gabion_test_options $<$<NOT:$<CONFIG:Debug>>:-O1>)

# The programs are built where they run: use the vector units of the x86-64-v3 level when present.
set(GABION_MARCH "auto" CACHE STRING "Value of -march; auto = x86-64-v3 where this machine has it; empty = compiler default")
if(GABION_MARCH STREQUAL "auto")
  set(gabion_march "")
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND EXISTS /proc/cpuinfo)
    file(STRINGS /proc/cpuinfo gabion_cpu_flags REGEX "^flags" LIMIT_COUNT 1)
    if(gabion_cpu_flags MATCHES " avx2 " AND gabion_cpu_flags MATCHES " fma " AND gabion_cpu_flags MATCHES " bmi2 ")
      set(gabion_march x86-64-v3)
    endif()
  endif()
else()
  set(gabion_march ${GABION_MARCH})
endif()
if(gabion_march)
  target_compile_options(gabion_options INTERFACE -march=${gabion_march})
endif()
# Libraries built for plain x86-64 stall when they are called with 256-bit registers in use, and the
# compiler leaves them so across calls between our own functions: 128-bit vectors are 18 % faster in a
# coupled run.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  target_compile_options(gabion_options INTERFACE -mprefer-vector-width=128)
endif()

configure_file(cmake/version.hpp.in generated/gabion_version.hpp @ONLY)
