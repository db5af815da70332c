# What a foreign code needs: cmake --install BUILD --component gabion_participant --prefix PREFIX, then
#     find_package(gabion_participant REQUIRED)
#     target_link_libraries(my_code PRIVATE gabion::participant)
include(CMakePackageConfigHelpers)
set(gabion_participant_package ${CMAKE_INSTALL_LIBDIR}/cmake/gabion_participant)

install(TARGETS gabion_participant EXPORT gabion_participant COMPONENT gabion_participant
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} NAMELINK_COMPONENT gabion_participant)
foreach(header base/error.hpp base/json.hpp base/process.hpp base/timer.hpp run/solver.hpp run/facets.hpp run/start.hpp run/state.hpp
        settings/config_reader.hpp settings/json_text.hpp settings/keys.hpp settings/nearest_word.hpp)
  cmake_path(GET header PARENT_PATH room)
  install(FILES ${PROJECT_SOURCE_DIR}/common/${header}
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gabion/common/${room} COMPONENT gabion_participant)
endforeach()
foreach(header channel/attention.hpp channel/heartbeat.hpp channel/keys.hpp channel/peer_watch.hpp channel/socket.hpp
        participant/connection.hpp participant/own_facets.hpp participant/request_source.hpp
        participant/state_machine.hpp participant/step_order.hpp participant/usage_error.hpp
        wire/deadlines.hpp wire/facets.hpp wire/handshake.hpp wire/message.hpp
        gabion_participant.h participant.hpp serve.hpp)
  cmake_path(GET header PARENT_PATH room)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gabion/protocol/${room}
    COMPONENT gabion_participant)
endforeach()
install(EXPORT gabion_participant NAMESPACE gabion:: FILE gabion_participant_targets.cmake
  DESTINATION ${gabion_participant_package} COMPONENT gabion_participant)
configure_package_config_file(gabion_participant-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/gabion_participant-config.cmake INSTALL_DESTINATION ${gabion_participant_package})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/gabion_participant-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gabion_participant-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/gabion_participant-config-version.cmake
  DESTINATION ${gabion_participant_package} COMPONENT gabion_participant)
