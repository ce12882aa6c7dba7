# How a library, a program, a test, a fuzz target and a benchmark are declared in this project.
# Every folder is one library kawara::<folder>; its sources are the .cpp files in it, but its DEPS are
# written out, so that a new edge between rooms shows in a CMakeLists and is talked about.

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)

# KISS-ICP's list, as far as gcc 12 and clang 14 share it. System headers are exempt (SYSTEM includes).
set(KAWARA_WARNINGS
    -Wall -Wextra -Wpedantic -Wshadow -Wcast-align -Wunused -Woverloaded-virtual -Wconversion
    -Wsign-conversion -Wdouble-promotion -Wformat=2 -Wnull-dereference -Wold-style-cast
    -Wnon-virtual-dtor -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND KAWARA_WARNINGS -Wduplicated-cond -Wlogical-op)
  # False positives of gcc 12 in Eigen, std::optional and std::string once sanitizers or -O3 inline them.
  list(APPEND KAWARA_WARNINGS -Wno-maybe-uninitialized -Wno-null-dereference -Wno-restrict)
endif()

add_library(kawara_options INTERFACE)
target_compile_options(kawara_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:${KAWARA_WARNINGS}>
                                                -fstack-protector-strong)
target_include_directories(kawara_options INTERFACE ${PROJECT_SOURCE_DIR})
if(KAWARA_SANITIZE)
  target_compile_options(kawara_options INTERFACE -fsanitize=${KAWARA_SANITIZE}
                                                  -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(kawara_options INTERFACE -fsanitize=${KAWARA_SANITIZE})
elseif(NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_compile_options(kawara_options INTERFACE -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
  target_link_options(kawara_options INTERFACE -Wl,-z,relro,-z,now)
endif()
if(KAWARA_FUZZ)
  target_compile_options(kawara_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# OpenCV's own CMake package sits in libopencv-dev, which pulls in 300 MB we do not use; three libraries suffice.
# imgcodecs brings GDAL and a hundred libraries more into a program, and 50 MB of its memory: what runs on the robot takes
# kawara::opencv_imgproc, and reads and writes pictures with vision/jpeg.hpp and vision/png.hpp.
add_library(kawara_opencv_imgproc INTERFACE)
add_library(kawara_opencv INTERFACE)
target_link_libraries(kawara_opencv INTERFACE kawara_opencv_imgproc)
foreach(part core imgproc imgcodecs)
  find_library(OPENCV_${part} opencv_${part} REQUIRED)
  if(part STREQUAL "imgcodecs")
    target_link_libraries(kawara_opencv INTERFACE ${OPENCV_${part}})
  else()
    target_link_libraries(kawara_opencv_imgproc INTERFACE ${OPENCV_${part}})
  endif()
endforeach()
target_include_directories(kawara_opencv_imgproc SYSTEM INTERFACE /usr/include/opencv4)
add_library(kawara::opencv_imgproc ALIAS kawara_opencv_imgproc)
add_library(kawara::opencv ALIAS kawara_opencv)

# Sanitizer builds compile everything once more; with what nearly every file reads compiled once, that costs half.
# Never in the dev build, which shows an include that is missing. Libraries and programs must be compiled alike for it:
# CMAKE_POSITION_INDEPENDENT_CODE off (else one is PIC, the other PIE).
option(KAWARA_PRECOMPILE "Precompiled standard headers" OFF)
if(KAWARA_PRECOMPILE)
  find_package(Eigen3 REQUIRED)
  file(WRITE ${PROJECT_BINARY_DIR}/precompiled.cpp "")
  add_library(kawara_precompiled STATIC ${PROJECT_BINARY_DIR}/precompiled.cpp)
  # Without its time of making, or ccache never meets the same one twice (run sets its CCACHE_SLOPPINESS).
  target_compile_options(kawara_options INTERFACE "SHELL:-Xclang -fno-pch-timestamp")
  target_link_libraries(kawara_precompiled PRIVATE kawara_options Eigen3::Eigen)
  target_precompile_headers(kawara_precompiled PRIVATE
    <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <chrono> <filesystem> <functional> <map> <memory> <mutex> <optional>
    <span> <string> <thread> <variant> <vector>)
endif()
function(kawara_precompile target)
  if(KAWARA_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM kawara_precompiled)
  endif()
endfunction()

# kawara_library(core DEPS Eigen3::Eigen ...): all .cpp of the folder except main files (*_main.cpp, main.cpp).
function(kawara_library name)
  cmake_parse_arguments(ARG "" "" "DEPS;PRIVATE_DEPS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "main\\.cpp$")
  if(sources)
    add_library(kawara_${name} STATIC ${sources})
    target_link_libraries(kawara_${name} PUBLIC kawara_options ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
    kawara_precompile(kawara_${name})
  else()
    add_library(kawara_${name} INTERFACE)
    target_link_libraries(kawara_${name} INTERFACE kawara_options ${ARG_DEPS})
  endif()
  add_library(kawara::${name} ALIAS kawara_${name})
endfunction()

# kawara_program(kawara-decode SOURCES decode_main.cpp DEPS kawara::drivers)
function(kawara_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE kawara_options ${ARG_DEPS})
endfunction()
