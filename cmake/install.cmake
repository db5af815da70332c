# What cmake --install and cpack write besides the participant library (protocol/install_participant.cmake): a folder with
# programs, scripts, Python package, scenes and pages, which scripts/setup knows by its lack of a CMakeLists.txt, and the
# command `gabion`, which calls the scripts.
set(gabion_tree lib/gabion)
install(TARGETS coupler mpm_solver fem_solver element_test RUNTIME DESTINATION ${gabion_tree}/bin COMPONENT gabion)
install(DIRECTORY scripts gabion configs docs structures DESTINATION ${gabion_tree} COMPONENT gabion USE_SOURCE_PERMISSIONS
  PATTERN __pycache__ EXCLUDE
  # What works on sources alone.
  REGEX "/scripts/(bench|check_structure|describe_keys|release_notes|releases|structure|test|test_on|verification|verify)$" EXCLUDE)
install(DIRECTORY protocol/python/gabion_participant DESTINATION ${gabion_tree}/protocol/python COMPONENT gabion
  PATTERN __pycache__ EXCLUDE)
install(FILES protocol/README.md DESTINATION ${gabion_tree}/protocol COMPONENT gabion)
install(FILES README.md CHANGELOG.md LICENSE CITATION.cff DESTINATION ${gabion_tree} COMPONENT gabion)
install(FILES LICENSE DESTINATION share/doc/gabion RENAME copyright COMPONENT gabion)
install(PROGRAMS cmake/gabion DESTINATION bin COMPONENT gabion)
# `import gabion` with Debian's python3, where the prefix is /usr.
file(CREATE_LINK ../../gabion/gabion ${CMAKE_BINARY_DIR}/generated/gabion SYMBOLIC)
install(FILES ${CMAKE_BINARY_DIR}/generated/gabion DESTINATION lib/python3/dist-packages COMPONENT gabion)

add_custom_target(uninstall
  COMMAND ${CMAKE_COMMAND} -D manifest=${CMAKE_BINARY_DIR}/install_manifest.txt
          -P ${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake
  VERBATIM)

# cpack -G DEB: libraries by what the programs are linked with, the rest by name.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME gabion)
set(CPACK_PACKAGE_CONTACT "the developers of Gabion <gabion@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "bash, openmpi-bin, libopenblas0-pthread, python3 (>= 3.11), python3-numpy, \
python3-scipy, python3-zmq, python3-matplotlib, python3-h5py, python3-jsonschema")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-gdal, libjs-three")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3-dolfinx, calculix-ccx, chromium")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_STRIP_FILES ON)
include(CPack)
