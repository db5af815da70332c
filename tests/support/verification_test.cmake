# gabion_verification(name LIBS lib... SOURCES file... [LONG] [TIMEOUT 900]): a program of verification
# problems. scripts/verify runs all of them; CTest runs those that are not LONG.
include_guard(GLOBAL)
include(${CMAKE_SOURCE_DIR}/tests/support/mpi_test.cmake)

function(gabion_verification name)
  cmake_parse_arguments(arg "LONG" "TIMEOUT" "LIBS;SOURCES" ${ARGN})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 900)
  endif()
  if(arg_LONG)
    add_executable(${name} ${arg_SOURCES})
    target_link_libraries(${name} PRIVATE ${arg_LIBS} gabion_test_support)
  else()
    gabion_mpi_test(${name} NUM_RANKS 1 LIBS ${arg_LIBS} LABEL verification TIMEOUT ${arg_TIMEOUT}
                    SOURCES ${arg_SOURCES})
  endif()
  list(LENGTH arg_SOURCES count)
  if(count GREATER 1)  # files of one program share names: each is compiled alone
    set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
  endif()
  add_dependencies(verification ${name})
  set_property(GLOBAL APPEND PROPERTY gabion_verification_programs $<TARGET_FILE:${name}>)
endfunction()
