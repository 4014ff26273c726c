# Everything from Debian; docs/dependencies.md says why each is here and under which licence.
# The model and the device need these, and no others.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
# Headers alone; the target that its package offers asks for a library that it does not need.
find_path(XSIMD_INCLUDE_DIR xsimd/xsimd.hpp REQUIRED)
find_package(Boost 1.74 REQUIRED)  # headers alone
if(PALPATE_PARTS STREQUAL "model")
  return()
endif()

find_package(GSL 2.7 REQUIRED)
find_package(SUNDIALS 6.4 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_path(MUSTACHE_INCLUDE_DIR kainjow/mustache.hpp REQUIRED)
find_package(tomlplusplus 3.3 REQUIRED)
set(HDF5_PREFER_PARALLEL OFF)
find_package(HDF5 1.10 REQUIRED COMPONENTS C)
find_path(VALGRIND_INCLUDE_DIR valgrind/callgrind.h REQUIRED)  # its counter is started and stopped by us
find_file(DYGRAPH_JS dygraph.min.js PATHS /usr/share/javascript/dygraphs REQUIRED)
find_file(DYGRAPH_CSS dygraph.min.css PATHS /usr/share/javascript/dygraphs REQUIRED)
find_file(THREE_JS three.min.js PATHS /usr/share/javascript/three REQUIRED)
find_package(ZLIB 1.2 REQUIRED)

# Third-party headers are not ours to warn about.
add_library(palpate_hdf5 INTERFACE)
target_include_directories(palpate_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})
target_link_libraries(palpate_hdf5 INTERFACE ${HDF5_LIBRARIES})

# Images of patients. DCMTK's own package asks for all of its libraries and theirs.
find_package(PNG 1.6 REQUIRED)
find_package(OpenSSL 3.0 REQUIRED COMPONENTS Crypto)
find_path(DCMTK_INCLUDE_DIR dcmtk/config/osconfig.h REQUIRED)
add_library(palpate_dcmtk INTERFACE)
target_include_directories(palpate_dcmtk SYSTEM INTERFACE ${DCMTK_INCLUDE_DIR})
foreach(part dcmjpeg dcmjpls dcmdata oflog ofstd)
  find_library(DCMTK_${part}_LIBRARY ${part} REQUIRED)
  target_link_libraries(palpate_dcmtk INTERFACE ${DCMTK_${part}_LIBRARY})
endforeach()
find_path(NIFTI_INCLUDE_DIR nifti/nifti1_io.h REQUIRED)
find_library(NIFTI_LIBRARY niftiio REQUIRED)
find_library(ZNZ_LIBRARY znz REQUIRED)
add_library(palpate_nifti INTERFACE)
target_include_directories(palpate_nifti SYSTEM INTERFACE ${NIFTI_INCLUDE_DIR} ${NIFTI_INCLUDE_DIR}/nifti)
target_link_libraries(palpate_nifti INTERFACE ${NIFTI_LIBRARY} ${ZNZ_LIBRARY})
