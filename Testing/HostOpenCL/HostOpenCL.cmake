# Builds the engine with the OpenCL of this folder (CL/opencl.hpp) in place of the system's. Its kernels are compiled
# when a program asks for them, by the compiler and with the sanitizers of the engine itself, and with the options that
# the environment variable HOST_OPENCL_FLAGS holds, -O1 without it.

set(folder "${PROJECT_BINARY_DIR}/HostKernels")
file(MAKE_DIRECTORY "${folder}")
set(flags "-g")
if (CHAINMAIL_SANITIZE)
  string(APPEND flags " -fsanitize=${CHAINMAIL_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer")
endif ()

target_sources(ChainMailKernels PRIVATE "${CMAKE_CURRENT_LIST_DIR}/HostOpenCL.cpp")
target_include_directories(ChainMailKernels BEFORE PRIVATE "${CMAKE_CURRENT_LIST_DIR}")
set_source_files_properties("${CMAKE_CURRENT_LIST_DIR}/HostOpenCL.cpp" PROPERTIES COMPILE_DEFINITIONS
  "HOST_OPENCL_FOLDER=\"${folder}\";HOST_OPENCL_COMPILER=\"${CMAKE_CXX_COMPILER}\";HOST_OPENCL_FLAGS=\"${flags}\";HOST_OPENCL_LANGUAGE=\"${CMAKE_CURRENT_LIST_DIR}/KernelLanguage.h\"")
target_link_libraries(ChainMailKernels PUBLIC ${CMAKE_DL_LIBS})
