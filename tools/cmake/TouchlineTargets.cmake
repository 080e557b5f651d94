# One CMake target a folder, with explicit links.
#
#   touchline_library(shared/geometry SOURCES a.cc PUBLIC touchline::shared_base PRIVATE Ceres::ceres)
#   touchline_program(touchline-edge SOURCES main.cc LINKS touchline::edge_pipeline)
#   touchline_test(unit_geometry LABELS unit SOURCES a_test.cc LINKS touchline::shared_geometry)
#
# A library's target is its folder with '/' turned into '_', and touchline:: before it.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)

find_program(TOUCHLINE_CCACHE ccache)
if(TOUCHLINE_CCACHE)
  # It keeps what was compiled with precompiled headers only when told that it may; paths count from the source folder,
  # so that two build folders share what is the same.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env "CCACHE_SLOPPINESS=pch_defines,time_macros"
    "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" "${TOUCHLINE_CCACHE}")
  set(CMAKE_C_COMPILER_LAUNCHER "${TOUCHLINE_CCACHE}")
endif()

# What every target of ours is compiled with. Eigen's alignment is pinned so that objects may cross into Debian's
# libraries (built for SSE2) whatever instruction set ours are built for.
add_library(touchline_flags INTERFACE)
target_include_directories(touchline_flags INTERFACE "${PROJECT_SOURCE_DIR}")
target_compile_options(touchline_flags INTERFACE -march=x86-64-v3 -Wall -Wextra -Wpedantic -Wshadow
  -Wnon-virtual-dtor -Woverloaded-virtual -Wold-style-cast -Wimplicit-fallthrough -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 sees overruns in its own library's strings when they come from a precompiled header: told, not fatal.
  target_compile_options(touchline_flags INTERFACE -Wno-error=array-bounds -Wno-error=restrict -Wno-error=stringop-overflow
    -fpch-preprocess)
else()
  target_compile_options(touchline_flags INTERFACE "SHELL:-Xclang -fno-pch-timestamp")
endif()
target_compile_definitions(touchline_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_DONT_PARALLELIZE)
target_link_libraries(touchline_flags INTERFACE Threads::Threads)
if(TOUCHLINE_SANITIZE STREQUAL "address")
  # Eigen pads its memory by hand when it sees ASan, Debian's Ceres does not, and what one takes the other gives back.
  target_compile_definitions(touchline_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  add_link_options(-fsanitize=address,undefined)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    add_compile_options(-fsanitize=fuzzer-no-link)  # the fuzzers see which branches our libraries take
  endif()
elseif(TOUCHLINE_SANITIZE STREQUAL "thread")
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
endif()

# Headers that nearly every file reads, compiled once: parsing them is most of a build's time. A file still includes what
# it uses (-DTOUCHLINE_PRECOMPILE=OFF tells). Every target that takes them is compiled with the flags above, and with
# nothing that changes these headers.
file(WRITE "${PROJECT_BINARY_DIR}/nothing.cc.in" "")
configure_file("${PROJECT_BINARY_DIR}/nothing.cc.in" "${PROJECT_BINARY_DIR}/nothing.cc" COPYONLY)
add_library(touchline_headers OBJECT "${PROJECT_BINARY_DIR}/nothing.cc")
target_link_libraries(touchline_headers PRIVATE touchline_flags Eigen3::Eigen)
target_precompile_headers(touchline_headers PRIVATE <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream>
  <functional> <map> <memory> <mutex> <numbers> <optional> <random> <set> <span> <sstream> <stop_token> <string> <thread>
  <utility> <variant> <vector> <Eigen/Core> <Eigen/Geometry> <Eigen/Cholesky> <Eigen/LU>)

function(touchline_precompiled name headers)
  if(TOUCHLINE_PRECOMPILE)
    target_precompile_headers(${name} REUSE_FROM ${headers})
  endif()
endfunction()

function(touchline_library folder)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  string(REPLACE "/" "_" name "${folder}")
  if(arg_SOURCES)
    add_library(${name} STATIC ${arg_SOURCES})
    target_link_libraries(${name} PUBLIC touchline_flags Eigen3::Eigen ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
    touchline_precompiled(${name} touchline_headers)
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE touchline_flags Eigen3::Eigen ${arg_PUBLIC})
  endif()
  add_library(touchline::${name} ALIAS ${name})
endfunction()

function(touchline_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE touchline_flags ${arg_LINKS})
  touchline_precompiled(${name} touchline_headers)
endfunction()

# A GoogleTest program, one a folder; every TEST becomes a CTest of its own with the labels given.
function(touchline_test name)
  if(NOT TOUCHLINE_TESTS)
    return()
  endif()
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS;LABELS" ${ARGN})
  find_package(GTest REQUIRED)
  include(GoogleTest)
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE touchline_flags ${arg_LINKS} GTest::gtest GTest::gmock GTest::gtest_main)
  if(NOT TARGET touchline_test_headers)
    add_library(touchline_test_headers OBJECT "${PROJECT_BINARY_DIR}/nothing.cc")
    target_link_libraries(touchline_test_headers PRIVATE touchline_flags Eigen3::Eigen GTest::gtest GTest::gmock)
    get_target_property(headers touchline_headers PRECOMPILE_HEADERS)
    target_precompile_headers(touchline_test_headers PRIVATE ${headers} <gmock/gmock.h> <gtest/gtest.h>)
  endif()
  touchline_precompiled(${name} touchline_test_headers)
  # gtest_discover_tests flattens lists: the first label is CTest's, `tsan` beside it only says what that build takes in.
  list(GET arg_LABELS 0 label)
  gtest_discover_tests(${name} WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}" DISCOVERY_MODE PRE_TEST
    TEST_PREFIX "${name}." PROPERTIES LABELS ${label})
  if("unit" IN_LIST arg_LABELS)
    add_dependencies(unit-tests ${name})
  endif()
  if("tsan" IN_LIST arg_LABELS)
    add_dependencies(tsan-tests ${name})
  endif()
endfunction()

# A bench program with a main of its own; its smoke test runs everything in it once, but for large pictures.
function(touchline_bench name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE touchline_flags touchline::tests_bench ${arg_LINKS})
  add_dependencies(benches ${name})
  if(TOUCHLINE_TESTS)
    add_test(NAME bench_smoke.${name} COMMAND ${name} --benchmark_min_time=0.000001
      WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
    set_tests_properties(bench_smoke.${name} PROPERTIES LABELS bench ENVIRONMENT "TOUCHLINE_BENCH_SMOKE=1;TOUCHLINE_BENCH_FRAMES=2")
  endif()
endfunction()
