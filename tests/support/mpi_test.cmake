# gabion_mpi_test(name NUM_RANKS 1 2 3 LIBS lib... SOURCES file... [LABEL unit] [TIMEOUT 900]):
# one test program with MPI and PETSc, run once with each number of ranks (tests name.1, name.2, ...).
include_guard(GLOBAL)

function(gabion_mpi_test name)
  cmake_parse_arguments(arg "" "LABEL;TIMEOUT" "LIBS;SOURCES;NUM_RANKS" ${ARGN})
  if(NOT arg_LABEL)
    set(arg_LABEL unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 900)
  endif()
  if(NOT arg_NUM_RANKS)
    message(FATAL_ERROR "gabion_mpi_test(${name}): NUM_RANKS is missing")
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LIBS} gabion_test_support)
  foreach(ranks ${arg_NUM_RANKS})
    add_test(NAME ${name}.${ranks}
             COMMAND ${MPIEXEC_EXECUTABLE} --allow-run-as-root --oversubscribe --bind-to none
                     -n ${ranks} $<TARGET_FILE:${name}>)
    set_tests_properties(${name}.${ranks} PROPERTIES
      LABELS ${arg_LABEL} TIMEOUT ${arg_TIMEOUT} PROCESSORS ${ranks}
      ENVIRONMENT "OMP_THREAD_LIMIT=1;OMP_NUM_THREADS=1;OPENBLAS_NUM_THREADS=1;OMPI_MCA_mpi_yield_when_idle=1")
  endforeach()
endfunction()
