# The engine and its unit tests for Windows, compiled and linked by MinGW-w64; where there is Wine, a program of the
# engine runs. In WORK/prefix comes together what a Windows machine would have: the headers of OpenCL and the import library
# of its loader, and GoogleTest.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

set(TOOLCHAIN "${CMAKE_CURRENT_LIST_DIR}/Windows/mingw-w64.cmake")
set(PREFIX "${WORK}/prefix")
set(OPTIONS "-DCMAKE_TOOLCHAIN_FILE=${TOOLCHAIN}" "-DCHAINMAIL_WINDOWS_PREFIX=${PREFIX}" -DCMAKE_BUILD_TYPE=Release)

# The headers of OpenCL are the same everywhere, and so are the names that its loader exports.
file(COPY "${OPENCL_INCLUDE_DIR}/CL" DESTINATION "${PREFIX}/include")
step("Listing what the loader of OpenCL exports" nm --dynamic --defined-only "${OPENCL_LIBRARY}")
string(REGEX MATCHALL "cl[A-Z][A-Za-z0-9]*" functions "${output}")
list(REMOVE_DUPLICATES functions)
list(JOIN functions "\n" functions)
file(WRITE "${WORK}/OpenCL.def" "LIBRARY OpenCL.dll\nEXPORTS\n${functions}\n")
file(MAKE_DIRECTORY "${PREFIX}/lib")
step("Making the import library of OpenCL.dll" x86_64-w64-mingw32-dlltool
  --input-def "${WORK}/OpenCL.def" --output-lib "${PREFIX}/lib/libOpenCL.dll.a")

configure("${GOOGLETEST}" "${WORK}/googletest" ${OPTIONS} "-DCMAKE_INSTALL_PREFIX=${PREFIX}" -DBUILD_GMOCK=OFF)
build("${WORK}/googletest")
step("Installing GoogleTest" "${CMAKE_COMMAND}" --install "${WORK}/googletest")

configure("${SOURCE}" "${WORK}/build" ${OPTIONS}
  -DCHAINMAIL_ENGINE_ONLY=ON
  -DCHAINMAIL_WARNINGS_AS_ERRORS=ON
  "-DCMAKE_INSTALL_PREFIX=${WORK}/installed")
build("${WORK}/build" --target ChainMailKernels ChainMailUnitTests)
step("Installing the engine" "${CMAKE_COMMAND}" --install "${WORK}/build")
step("Looking into the unit tests" x86_64-w64-mingw32-objdump --private-headers "${WORK}/build/Testing/Unit/ChainMailUnitTests.exe")
string(REGEX MATCHALL "DLL Name: [^\n]*" libraries "${output}")
if (NOT "DLL Name: OpenCL.dll" IN_LIST libraries OR "${libraries}" MATCHES "libstdc|libgcc|winpthread")
  message(FATAL_ERROR "The unit tests need other libraries than OpenCL.dll and those of Windows: ${libraries}")
endif ()

configure("${SOURCE}/Testing/Consumer" "${WORK}/consumer" ${OPTIONS} "-DChainMail_DIR=${WORK}/installed/lib/cmake/ChainMail")
build("${WORK}/consumer")

# Under Wine, on the OpenCL of this machine, whose environment variables do not reach a driver there, and which does not tell
# when a buffer is gone.
find_program(WINE NAMES wine64 wine PATHS /usr/lib/wine)
if (WINE)
  set(ENV{WINEPREFIX} "${WORK}/wine")
  set(ENV{WINEDEBUG} -all)
  step("Running the outside program under Wine" "${WINE}" "${WORK}/consumer/useEngine.exe")
  step("Running unit tests under Wine" "${WINE}" "${WORK}/build/Testing/Unit/ChainMailUnitTests.exe"
    "--gtest_filter=Oracles.*:ProgramCache.*:Threads.*:Simulation.*:-Simulation.PeakOfTheDevicesMemory")
endif ()
