# A folder inside VTK's own build: a small project that finds and builds remote modules with VTK's own calls.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

file(COPY "${CMAKE_CURRENT_LIST_DIR}/InsideVTK/" DESTINATION "${WORK}/VTK")
copy_repository("${WORK}/VTK/Remote/ChainMail")
configure("${WORK}/VTK" "${WORK}/build" "-DVTK_DIR=${VTK_DIR}")
build("${WORK}/build")
step("Running a program of the same build" "${WORK}/build/useFilter")
