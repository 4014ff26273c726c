# Everything from Debian; docs/dependencies.md says why each is here and under which licence.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
# Headers alone; the target that its package offers asks for a library that it does not need.
find_path(XSIMD_INCLUDE_DIR xsimd/xsimd.hpp REQUIRED)
find_package(GSL 2.7 REQUIRED)
find_package(SUNDIALS 6.4 REQUIRED)
find_package(Boost 1.74 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(tomlplusplus 3.3 REQUIRED)
set(HDF5_PREFER_PARALLEL OFF)
find_package(HDF5 1.10 REQUIRED COMPONENTS C)
find_path(VALGRIND_INCLUDE_DIR valgrind/callgrind.h REQUIRED)  # its counter is started and stopped by us
find_program(GNUPLOT gnuplot REQUIRED)
find_file(DYGRAPH_JS dygraph.min.js PATHS /usr/share/javascript/dygraphs REQUIRED)
find_file(DYGRAPH_CSS dygraph.min.css PATHS /usr/share/javascript/dygraphs REQUIRED)

# Third-party headers are not ours to warn about.
add_library(palpate_hdf5 INTERFACE)
target_include_directories(palpate_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})
target_link_libraries(palpate_hdf5 INTERFACE ${HDF5_LIBRARIES})
