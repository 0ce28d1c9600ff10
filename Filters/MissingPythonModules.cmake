# Debian 13 has a VTK and a ParaView that CMake refuses. Their lists of imported Python modules (VTKPython-targets.cmake
# and two of ParaView's) name files such as vtkCommonCore.so where the package holds
# vtkCommonCore.cpython-313-x86_64-linux-gnu.so. No file of the system has to change for that: CMake skips a list whose
# targets are all defined already, so they are defined here first, from copies of the lists with the right names.
#
# chainmail_name_python_modules(<VTK or ParaView>), called before find_package of it, does so where files are missing
# and others of such a name exist, and nothing elsewhere. The installed package brings this file along for the programs
# that find it.
function (chainmail_name_python_modules package)
  set(folder "${${package}_DIR}")
  if (NOT folder)
    # No package has this version, so CMake reads nothing but version files and says which packages it looked at.
    find_package(${package} 9999 CONFIG QUIET)
    unset(${package}_DIR CACHE)
    set(configs "${${package}_CONSIDERED_CONFIGS}")
    if (NOT configs)
      return ()
    endif ()
    list(GET configs 0 config)
    get_filename_component(folder "${config}" DIRECTORY)
  endif ()

  # ParaView has a VTK of its own, whose list it needs first.
  file(GLOB listsOfVTK "${folder}/vtk/*Python*-targets.cmake")
  file(GLOB lists "${folder}/*Python*-targets.cmake")
  foreach (list IN LISTS listsOfVTK lists)
    get_filename_component(folder "${list}" DIRECTORY)
    get_filename_component(name "${list}" NAME_WE)
    file(GLOB prefixFile "${folder}/*-prefix.cmake")
    if (NOT prefixFile)
      continue ()
    endif ()
    include("${prefixFile}")

    # The files of modules are named in the list's other parts, one for each build type.
    set(suffixes "")
    file(GLOB parts "${folder}/${name}-*.cmake")
    foreach (part IN LISTS parts list)
      file(READ "${part}" text)
      string(REPLACE "\${_IMPORT_PREFIX}/" "${_vtk_module_import_prefix}/" text "${text}")
      string(REGEX MATCHALL "\"/[^\"]*\\.so\"" modules "${text}")
      list(REMOVE_DUPLICATES modules)
      foreach (module IN LISTS modules)
        string(REGEX REPLACE "^\"(.*)\\.so\"$" "\\1" module "${module}")
        file(GLOB there "${module}.*.so")
        list(LENGTH there count)
        if (count EQUAL 1 AND NOT EXISTS "${module}.so")
          string(REPLACE "\"${module}.so\"" "\"${there}\"" text "${text}")
          string(REPLACE "${module}" "" suffix "${there}")
          list(APPEND suffixes "${suffix}")
        endif ()
      endforeach ()
      get_filename_component(partName "${part}" NAME)
      set("text_${partName}" "${text}")
    endforeach ()

    if (suffixes)
      list(REMOVE_DUPLICATES suffixes)
      message(STATUS "${list} names Python modules *.so that are not there; using *${suffixes}")
      foreach (part IN LISTS parts list)
        get_filename_component(partName "${part}" NAME)
        file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/PythonModules/${partName}" "${text_${partName}}")
      endforeach ()
      include("${CMAKE_BINARY_DIR}/CMakeFiles/PythonModules/${name}.cmake")
    endif ()
  endforeach ()
endfunction ()
