# gabion_compile_together(TARGET PATTERN): files of a library whose names match are compiled together, five at a time. The
# headers and templates that they share take half of the time. It is for files that compute little: which functions the
# compiler inlines, and with that the last bit of a result, stays as it is where results are computed. A name of one file
# (anonymous namespace) must be no other file's of its library.
function(gabion_compile_together target pattern)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "${pattern}")
  set(count 0)
  foreach(source ${sources})
    math(EXPR group "${count} / 5")
    set_property(SOURCE ${source} PROPERTY UNITY_GROUP "${target}_${group}")
    math(EXPR count "${count} + 1")
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${GABION_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()
