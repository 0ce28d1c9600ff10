# CMake's toolchain file for Windows, with the MinGW-w64 of Debian (g++-mingw-w64-x86-64-posix, the one with threads of
# C++). What else a build needs is looked for in CHAINMAIL_WINDOWS_PREFIX, never on this machine.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_EXE_LINKER_FLAGS_INIT -static) # but for OpenCL.dll a program runs by itself

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES CHAINMAIL_WINDOWS_PREFIX)
set(CMAKE_FIND_ROOT_PATH "${CHAINMAIL_WINDOWS_PREFIX}" /usr/x86_64-w64-mingw32)
set(CMAKE_PREFIX_PATH /)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
