# The outside program of Testing/Consumer against the ChainMail in PREFIX, which PlainVTK.cmake or Installed.cmake made.

configure("${SOURCE}/Testing/Consumer" "${WORK}/consumer" "-DCMAKE_PREFIX_PATH=${PREFIX}")
build("${WORK}/consumer")
step("Running the outside program of the engine" "${WORK}/consumer/useEngine")
step("Running the outside program of the filter" "${WORK}/consumer/useFilter")

# Another VTK than the one that the module was built with is refused, in words. A stub is enough: its version is all
# that is read.
file(WRITE "${WORK}/otherVTK/VTKConfig.cmake" "set(VTK_VERSION 9.99.0)\n")
refused("Offering another VTK" "was built with VTK [0-9.]+ and cannot be used with VTK 9.99.0"
  "${CMAKE_COMMAND}" -S "${SOURCE}/Testing/Consumer" -B "${WORK}/refused" -G "${GENERATOR}"
  "-DCMAKE_PREFIX_PATH=${PREFIX}" "-DVTK_DIR=${WORK}/otherVTK")
