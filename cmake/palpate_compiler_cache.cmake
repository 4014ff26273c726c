# Where ccache is installed it keeps what was compiled, for a checkout in another folder too; CCACHE_DISABLE=1 leaves it
# out.
find_program(PALPATE_CCACHE ccache)
if(PROJECT_IS_TOP_LEVEL AND PALPATE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env
    CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros "${PALPATE_CCACHE}")
endif()
