# Fails when Rooms.cmake does not notice what is wrong in a copy of FOLDER, spoiled in WORK.

cmake_minimum_required(VERSION 3.18)

function (spoil what)
  file(REMOVE_RECURSE "${WORK}")
  file(COPY "${FOLDER}/" DESTINATION "${WORK}")
  set(what "${what}" PARENT_SCOPE)
endfunction ()

function (noticed message)
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DFOLDER=${WORK}" -P "${CMAKE_CURRENT_LIST_DIR}/Rooms.cmake"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " said "${output}") # CMake wraps its messages
  if (result EQUAL 0 OR NOT said MATCHES "${message}")
    message("${output}")
    message(FATAL_ERROR "${what} was not noticed")
  endif ()
endfunction ()

spoil("An include from above")
file(APPEND "${WORK}/Core/Model.cpp" "#include \"Simulation.h\"\n")
noticed("Model.cpp in Core includes Simulation.h from above")

spoil("A kernel's include from above")
file(APPEND "${WORK}/Core/element.clh" "  # include \"brick.clh\"\n")
noticed("element.clh in Core includes brick.clh from above, in Bricks")

spoil("An include of a file that is not there")
file(APPEND "${WORK}/Simulation.cpp" "#include \"Nowhere.h\"\n")
noticed("includes Nowhere.h, which is in no room")

spoil("A room without files")
file(REMOVE_RECURSE "${WORK}/Resampling")
noticed("The room Resampling has no sources")

spoil("A new room")
file(MAKE_DIRECTORY "${WORK}/Cellar")
noticed("Cellar is not among the rooms")

spoil("Two files of one name")
file(COPY "${WORK}/Core/Error.h" DESTINATION "${WORK}/Device")
noticed("There are two files Error.h")

file(REMOVE_RECURSE "${WORK}")
