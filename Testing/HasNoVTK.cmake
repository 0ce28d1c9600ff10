# Fails when a file of FOLDER, or of a folder in it, includes a header of VTK.

file(GLOB_RECURSE files "${FOLDER}/*.h" "${FOLDER}/*.cpp" "${FOLDER}/*.cxx" "${FOLDER}/*.cl" "${FOLDER}/*.clh")
if (NOT files)
  message(FATAL_ERROR "${FOLDER} has no sources")
endif ()
foreach (file IN LISTS files)
  file(STRINGS "${file}" lines REGEX "^[ \t]*#[ \t]*include[ \t]*[<\"]([^>\"]*/)?[vV][tT][kK]")
  if (lines)
    message(SEND_ERROR "${file} includes VTK: ${lines}")
  endif ()
endforeach ()
