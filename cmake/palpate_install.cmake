# What `cmake --install` copies, and the package that find_package(palpate) reads (docs/install.md).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(palpate_include_dir "${CMAKE_INSTALL_INCLUDEDIR}/palpate")
set(palpate_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/palpate")

# The interface of simulators under test: one header in plain C that includes nothing of ours.
add_library(palpate_subject INTERFACE)
add_library(palpate::subject ALIAS palpate_subject)
target_include_directories(palpate_subject INTERFACE
  "$<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/validation/subject>" "$<INSTALL_INTERFACE:${palpate_include_dir}>")
set_target_properties(palpate_subject PROPERTIES EXPORT_NAME subject)

if(PALPATE_INSTALL)
  install(FILES validation/subject/palpate_subject.h DESTINATION "${palpate_include_dir}" COMPONENT subject)
  install(TARGETS palpate_subject EXPORT palpate_subject)
  install(EXPORT palpate_subject NAMESPACE palpate:: FILE palpate_subject.cmake
    DESTINATION "${palpate_package_dir}" COMPONENT subject)
  configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/palpate_config.cmake.in"
    "${CMAKE_CURRENT_BINARY_DIR}/palpate-config.cmake" INSTALL_DESTINATION "${palpate_package_dir}"
    NO_SET_AND_CHECK_MACRO)
  # Before 1.0 a minor version may change an interface.
  write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/palpate-config-version.cmake"
    COMPATIBILITY SameMinorVersion)
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/palpate-config.cmake"
    "${CMAKE_CURRENT_BINARY_DIR}/palpate-config-version.cmake"
    DESTINATION "${palpate_package_dir}" COMPONENT subject)
endif()

# palpate_install_library(<component> TARGETS <name>... HEADERS <file>...): libraries of palpate_add_library with their
# public headers, which a consumer includes as this project does: "model/problem/scene.hpp".
function(palpate_install_library component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "TARGETS;HEADERS")
  foreach(name IN LISTS arg_TARGETS)
    target_compile_features(palpate_${name} PUBLIC cxx_std_20)
    target_include_directories(palpate_${name} INTERFACE
      "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>" "$<INSTALL_INTERFACE:${palpate_include_dir}>")
    set_target_properties(palpate_${name} PROPERTIES EXPORT_NAME ${name})
  endforeach()
  if(NOT PALPATE_INSTALL)
    return()
  endif()
  list(TRANSFORM arg_TARGETS PREPEND palpate_)
  install(TARGETS ${arg_TARGETS} EXPORT palpate_${component}
    ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT ${component})
  install(EXPORT palpate_${component} NAMESPACE palpate:: FILE palpate_${component}.cmake
    DESTINATION "${palpate_package_dir}" COMPONENT ${component})
  foreach(header IN LISTS arg_HEADERS)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES ${header} DESTINATION "${palpate_include_dir}/${component}/${folder}" COMPONENT ${component})
  endforeach()
endfunction()
