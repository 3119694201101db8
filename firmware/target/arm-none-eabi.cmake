# Toolchain file for bare Cortex-M cores; needs the packages gcc-arm-none-eabi and libnewlib-arm-none-eabi. For example
#   cmake -S . -B build-m3 --toolchain firmware/target/arm-none-eabi.cmake -DSSV_CPU=m3 -DSSV_REAL=fixed \
#     -DSSV_BUILD_HOST=OFF -DSSV_BUILD_TESTS=OFF
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(SSV_CPU m3 CACHE STRING "Core to build for: m3 (no floating-point unit), m4f (single precision) or m7 (double)")
set_property(CACHE SSV_CPU PROPERTY STRINGS m3 m4f m7)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SSV_CPU)
set(options_m3 "-mcpu=cortex-m3")
set(options_m4f "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16")
set(options_m7 "-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16")
if(NOT DEFINED options_${SSV_CPU})
  message(FATAL_ERROR "SSV_CPU is '${SSV_CPU}'; it must be m3, m4f or m7.")
endif()
set(CMAKE_BUILD_TYPE MinSizeRel CACHE STRING "Small first: -Os")
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_C_FLAGS_INIT "-mthumb ${options_${SSV_CPU}} -ffunction-sections -fdata-sections -fstack-usage")
if(SSV_REAL STREQUAL "fixed")
  # Structures of 64-bit numbers do not fit the registers: to split them costs 2 % of the text.
  string(APPEND CMAKE_C_FLAGS_INIT " -fno-tree-sra")
endif()
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)  # a program would need a linker script
