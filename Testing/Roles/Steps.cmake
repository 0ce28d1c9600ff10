# What the scripts of this folder share. Each plays one role of the repository from an empty folder WORK, as a user
# would, and stops at the first step that fails. Given with -D: SOURCE (the repository), WORK, GENERATOR, BUILD_JOBS, and
# LONG, which asks for what takes minutes.

cmake_minimum_required(VERSION 3.19)

function (step what)
  message(STATUS "${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if (NOT result EQUAL 0)
    message("${output}") # apart: CMake would wrap it
    message(FATAL_ERROR "${what}: failed with ${result}")
  endif ()
  set(output "${output}" PARENT_SCOPE)
endfunction ()

# A step that has to fail and say something that matches `message`.
function (refused what message)
  message(STATUS "${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " said "${output}") # CMake wraps its messages
  if (result EQUAL 0 OR NOT said MATCHES "${message}")
    message("${output}")
    message(FATAL_ERROR "${what}: ended with ${result} where a failure that says \"${message}\" was expected")
  endif ()
endfunction ()

function (configure source build)
  step("Configuring ${source}" "${CMAKE_COMMAND}" -S "${source}" -B "${build}" -G "${GENERATOR}" ${ARGN})
endfunction ()

function (build build)
  step("Building ${build}" "${CMAKE_COMMAND}" --build "${build}" --parallel ${BUILD_JOBS} ${ARGN})
endfunction ()

# The part of the repository that a project takes which has it as a folder.
function (copy_repository destination)
  file(COPY "${SOURCE}/CMakeLists.txt" "${SOURCE}/paraview.plugin" "${SOURCE}/vtk.module" "${SOURCE}/LICENSE"
    "${SOURCE}/Kernels" "${SOURCE}/Filters" "${SOURCE}/Plugin" "${SOURCE}/Testing"
    DESTINATION "${destination}"
    PATTERN "__pycache__" EXCLUDE)
  file(COPY "${SOURCE}/Data/make_forearm.py" DESTINATION "${destination}/Data") # a source of the plugin
endfunction ()

file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
