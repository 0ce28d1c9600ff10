# The module alone, against the VTK in VTK_DIR, and an outside program that uses what it installs. The short form ends when
# CMake has found all that it needs: InsideVTK.cmake builds the same module, Installed.cmake has the same outside program.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

configure("${SOURCE}" "${WORK}/build"
  "-DVTK_DIR=${VTK_DIR}"
  -DBUILD_TESTING=OFF
  -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_DISABLE_FIND_PACKAGE_ParaView=ON
  "-DCMAKE_INSTALL_PREFIX=${WORK}/prefix")
if (NOT LONG)
  return ()
endif ()
build("${WORK}/build")
step("Installing the module" "${CMAKE_COMMAND}" --install "${WORK}/build")

set(PREFIX "${WORK}/prefix")
include("${CMAKE_CURRENT_LIST_DIR}/Consumer.cmake")
