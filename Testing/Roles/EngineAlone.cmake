# The engine without VTK: an outside program that uses what it installs, and its own tests, with the sanitizers on.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

# Leaks are valgrind's to find (../Checks). Here PoCL and the compiler inside it keep what they allocate until the process
# ends, and the search falls over threads of PoCL that are just ending and does not work in every container.
#
# The compiler inside PoCL puts an alternate signal stack of its own in place of the sanitizer's, in the thread that
# compiles first; where that is not the main thread the sanitizer would give back, at its end, a stack that is not its own.
set(ENV{ASAN_OPTIONS} detect_leaks=0:use_sigaltstack=0)

configure("${SOURCE}" "${WORK}/build"
  -DCHAINMAIL_ENGINE_ONLY=ON
  -DCHAINMAIL_SANITIZE=address,undefined
  -DCMAKE_BUILD_TYPE=Debug
  -DCMAKE_CXX_FLAGS=-O1 # half the time of -O2 to build, a third of -O0 to run
  -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON
  -DCMAKE_DISABLE_FIND_PACKAGE_ParaView=ON
  "-DCMAKE_INSTALL_PREFIX=${WORK}/prefix")
build("${WORK}/build" --target ChainMailKernels)
build("${WORK}/build" --target ChainMailUnitTests)
# What takes minutes as it is would take much longer here: a few of the random scenes, and none of what runs the same code again.
set(ENV{CHAINMAIL_RANDOM_SCENES} 4)
step("Testing the sanitized engine" "${CMAKE_CTEST_COMMAND}" --test-dir "${WORK}/build" --output-on-failure --no-tests=error
  --parallel "${BUILD_JOBS}" --label-regex Unit --exclude-regex "Extremes|Metamorphic|Plastic|Paper|BitsDoNotDependOnBricks")
step("Installing the engine" "${CMAKE_COMMAND}" --install "${WORK}/build")

configure("${SOURCE}/Testing/Consumer" "${WORK}/consumer"
  "-DCMAKE_PREFIX_PATH=${WORK}/prefix"
  -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON)
build("${WORK}/consumer")
step("Running the outside program" "${WORK}/consumer/useEngine")
