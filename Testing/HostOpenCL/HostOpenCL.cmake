# Builds the engine with the OpenCL of this folder instead of the system's; CL/opencl.hpp says what it is. The runtime
# compiles kernels into the folder HostKernels of the build, by the compiler and with the sanitizers of the engine.

set(folder "${PROJECT_BINARY_DIR}/HostKernels")
file(MAKE_DIRECTORY "${folder}")
set(flags "-g")
if (CHAINMAIL_SANITIZE)
  string(APPEND flags " -fsanitize=${CHAINMAIL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer")
endif ()

target_sources(ChainMailKernels PRIVATE "${CMAKE_CURRENT_LIST_DIR}/HostOpenCL.cpp")
# The unit tests use classes that hold buffers, so they need the same header.
target_include_directories(ChainMailKernels BEFORE PUBLIC "$<BUILD_INTERFACE:${CMAKE_CURRENT_LIST_DIR}>")
set(definitions
  "HOST_OPENCL_FOLDER=\"${folder}\""
  "HOST_OPENCL_COMPILER=\"${CMAKE_CXX_COMPILER}\""
  "HOST_OPENCL_FLAGS=\"${flags}\""
  "HOST_OPENCL_LANGUAGE=\"${CMAKE_CURRENT_LIST_DIR}/KernelLanguage.h\"")
set_source_files_properties("${CMAKE_CURRENT_LIST_DIR}/HostOpenCL.cpp" PROPERTIES COMPILE_DEFINITIONS "${definitions}")
target_link_libraries(ChainMailKernels PUBLIC ${CMAKE_DL_LIBS})
