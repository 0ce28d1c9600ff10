# The engine without VTK, with the sanitizers on: its own tests, then an outside program that uses what it installs.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

configure("${SOURCE}" "${WORK}/build"
  -DCHAINMAIL_ENGINE_ONLY=ON
  -DCHAINMAIL_SANITIZE=address,undefined
  -DCMAKE_BUILD_TYPE=Debug
  -DCMAKE_CXX_FLAGS=-O1 # half the time of -O2 to build, a third of -O0 to run
  -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON
  -DCMAKE_DISABLE_FIND_PACKAGE_ParaView=ON
  "-DCMAKE_INSTALL_PREFIX=${WORK}/prefix")
build("${WORK}/build")
# What takes minutes as it is would take much longer here: a few of the random scenes, and none of what runs the same code again.
set(ENV{CHAINMAIL_RANDOM_SCENES} 4)
# Once in thousands of tests the leak sanitizer's own tracer falls over a thread of PoCL that is just ending: such a test runs again.
step("Testing the sanitized engine" "${CMAKE_CTEST_COMMAND}" --test-dir "${WORK}/build" --output-on-failure --no-tests=error --repeat until-pass:2
  --parallel "${BUILD_JOBS}" --label-regex Unit --exclude-regex "Extremes|Metamorphic|Plastic|Paper|BitsDoNotDependOnBricks")
step("Installing the engine" "${CMAKE_COMMAND}" --install "${WORK}/build")

configure("${SOURCE}/Testing/Consumer" "${WORK}/consumer"
  "-DCMAKE_PREFIX_PATH=${WORK}/prefix"
  -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON)
build("${WORK}/consumer")
step("Running the outside program" "${WORK}/consumer/useEngine")
