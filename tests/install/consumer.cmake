# Installs the build into a scratch prefix, then configures, builds and runs outside projects.
cmake_policy(VERSION 3.25)
set(here "${CMAKE_CURRENT_LIST_DIR}")
set(prefix "${SCRATCH}/prefix")
file(REMOVE_RECURSE "${SCRATCH}")

function(run)
  execute_process(COMMAND ${ARGV} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${command}\nended with ${status}:\n${output}")
  endif()
endfunction()

# Configures and builds a project in the scratch folder.
function(build name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FROM" "OPTIONS")
  if(NOT arg_FROM)
    set(arg_FROM ${name})
  endif()
  run("${CMAKE_COMMAND}" -S "${here}/${arg_FROM}" -B "${SCRATCH}/${name}" -G "${GENERATOR}" -DCMAKE_C_COMPILER=${C}
    ${arg_OPTIONS})
  run("${CMAKE_COMMAND}" --build "${SCRATCH}/${name}" --parallel 2)
endfunction()

# run_refused(<expected> <command>...): the command must fail, with output that matches.
function(run_refused expected)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nmust fail with \"${expected}\"; it succeeds")
  elseif(NOT output MATCHES "${expected}")
    message(FATAL_ERROR "${ARGN}\nmust fail with \"${expected}\"; its output is:\n${output}")
  endif()
endfunction()

set(components model device subject)
if(EXISTS "${PROGRAM}")
  list(APPEND components programs)
endif()
foreach(component IN LISTS components)
  run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${prefix}" --component ${component})
endforeach()

# Nothing of the build may be in what consumers read.
file(GLOB_RECURSE package "${prefix}/*/cmake/palpate/*.cmake")
if(NOT package)
  message(FATAL_ERROR "${prefix} has no CMake package")
endif()
foreach(file IN LISTS package)
  file(READ "${file}" text)
  string(FIND "${text}" "${SOURCE}" source_at)
  string(FIND "${text}" "${BUILD}" build_at)
  if(NOT source_at EQUAL -1 OR NOT build_at EQUAL -1)
    message(SEND_ERROR "${file} names a folder of the build")
  endif()
  if(text MATCHES "INTERFACE_(COMPILE_OPTIONS|COMPILE_DEFINITIONS|LINK_OPTIONS)|[ \";](-[WfmO][^ \";]*)|GSL|SUNDIALS|HDF5")
    message(SEND_ERROR "${file} hands \"${CMAKE_MATCH_0}\" on to consumers")
  endif()
endforeach()

# Every public header compiles without private ones, and without a warning of the consumer's own options.
file(GLOB_RECURSE headers RELATIVE "${prefix}/include/palpate" "${prefix}/include/palpate/*.hpp")
if(NOT "model/stepping/simulation.hpp" IN_LIST headers OR NOT "device/servo_loop.hpp" IN_LIST headers)
  message(FATAL_ERROR "${prefix} lacks public headers: ${headers}")
endif()
list(TRANSFORM headers REPLACE "(.+)" "#include \"\\1\"\n")
file(WRITE "${SCRATCH}/headers.cpp" ${headers} "#include <palpate_subject.h>\n")

set(cxx "-DHEADERS=${SCRATCH}/headers.cpp" "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_CXX_FLAGS=${FLAGS}")
build(model OPTIONS ${cxx} "-DCMAKE_PREFIX_PATH=${prefix}")
run("${SCRATCH}/model/consumer")

# A consumer of the interface of subjects needs no C++ and no Eigen.
build(subject OPTIONS "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON
  "-DSKELETON=${SOURCE}/fixtures/subjects/skeletons/subject.c")
if(EXISTS "${PROGRAM}")
  file(GLOB library "${prefix}/lib*/palpate/palpate_subject_model.so" "${prefix}/lib/*/palpate/palpate_subject_model.so")
  run("${prefix}/bin/palpate" subject check --quiet "${SCRATCH}/subject/subject.so" --out "${SCRATCH}/check")
  run("${prefix}/bin/palpate" run "${prefix}/share/palpate/scenes/cube.toml" --subject "${library}" --quiet
    --out "${SCRATCH}/run")
endif()
run_refused("component reference is not in this installation" "${CMAKE_COMMAND}" -S "${here}/subject" -B "${SCRATCH}/unknown" -G "${GENERATOR}"
  -DCMAKE_C_COMPILER=${C} "-DCMAKE_PREFIX_PATH=${prefix}" -DCOMPONENT=reference)

# Eigen allocates in another way with AVX: such a program must not link.
if(CMAKE_HOST_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" AND NOT FLAGS MATCHES "-m")
  run("${CMAKE_COMMAND}" -S "${here}/model" -B "${SCRATCH}/avx" -G "${GENERATOR}" ${cxx} -DCMAKE_CXX_FLAGS=-mavx
    "-DCMAKE_PREFIX_PATH=${prefix}")
  run_refused("has_same_eigen_memory_as_library" "${CMAKE_COMMAND}" --build "${SCRATCH}/avx")
endif()

# From the source tree. Of the libraries only the device is compiled; the build has compiled the model.
build(source-subject FROM subdirectory OPTIONS "-DPALPATE_SOURCE=${SOURCE}" -DPALPATE_PARTS=subject
  -DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON)
build(source-model FROM subdirectory OPTIONS ${cxx} "-DPALPATE_SOURCE=${SOURCE}" -DPALPATE_PARTS=model
  "-DCONSUMER=${here}/model/consumer.cpp")
run("${CMAKE_COMMAND}" --build "${SCRATCH}/source-model" --target palpate_device --parallel 2)
