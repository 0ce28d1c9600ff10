# The Debian package of the stand-alone project in BUILD: what is in it, what it asks for, and that ParaView finds the
# plugin in its files. That it installs is tryPackage.sh's to show, in a bare system.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

step("Making the package" "${CMAKE_CPACK_COMMAND}" --config "${BUILD}/CPackConfig.cmake" -B "${WORK}")
file(GLOB packages "${WORK}/chainmail_*.deb")
list(LENGTH packages count)
if (NOT count EQUAL 1)
  message(FATAL_ERROR "Instead of one package there are: ${packages}")
endif ()

step("Reading what it asks for" dpkg-deb --field "${packages}" Depends Recommends)
foreach (part "paraview \\(>= [0-9]" "paraview \\(<< [0-9]" "libc6 " "ocl-icd-libopencl1" "Recommends:.*pocl-opencl-icd \\| opencl-icd")
  if (NOT output MATCHES "${part}")
    message(FATAL_ERROR "The package does not ask for ${part}: ${output}")
  endif ()
endforeach ()

step("Unpacking it" dpkg-deb --extract "${packages}" "${WORK}/root")
file(GLOB_RECURSE files RELATIVE "${WORK}/root/usr" "${WORK}/root/*")
foreach (part "^${PLUGIN_DESTINATION}/ChainMail/ChainMail.so$"
    "^${PLUGIN_DESTINATION}/ChainMail/ChainMailCompileAhead$" "^${PYTHON_DESTINATION}/chainmail/ChainMailFilters.*so$"
    "^include/ChainMail/vtkChainMailDeformation.h$" "^include/ChainMail/Kernels/Simulation.h$" "/ChainMailConfig.cmake$"
    "^share/ChainMail/Presets.json$" "^share/doc/chainmail/copyright$" "^share/doc/chainmail/README.Debian$"
    "^share/doc/chainmail/README.md$" "^share/doc/chainmail/Data/Using.md$" "^share/doc/chainmail/Data/Images/forearm.png$"
    "^share/doc/chainmail/Data/main_job.py$")
  set(found ${files})
  list(FILTER found INCLUDE REGEX "${part}")
  if (NOT found)
    message(FATAL_ERROR "The package has no ${part}: ${files}")
  endif ()
endforeach ()

# The list of plugins, or of such lists, that ParaView finds by itself: all that is named there is there.
set(root "${WORK}/root/usr")
if (EXISTS "${root}/bin/paraview.conf")
  file(STRINGS "${root}/bin/paraview.conf" named)
else ()
  file(STRINGS "${root}/share/paraview/plugins" named REGEX filename)
  string(REGEX REPLACE ".*filename=\"([^\"]*)\".*" "\\1" named "${named}")
endif ()
set(found 0)
foreach (file IN LISTS named)
  get_filename_component(file "${file}" ABSOLUTE BASE_DIR /usr/bin)
  string(REGEX REPLACE "^/usr/" "" inPackage "${file}")
  if (EXISTS "${root}/${inPackage}")
    set(found 1)
  elseif (NOT EXISTS "${file}")
    message(FATAL_ERROR "ParaView is told of ${file}, which is not there: ${named}")
  endif ()
endforeach ()
if (NOT found)
  message(FATAL_ERROR "ParaView is not told of the plugin: ${named}")
endif ()
step("Loading the plugin from its files" "${CMAKE_COMMAND}" -E env --unset=PV_PLUGIN_PATH
  "PV_PLUGIN_CONFIG_FILE=${root}/${PLUGIN_DESTINATION}/ChainMail.xml"
  "PYTHONPATH=${root}/${PYTHON_DESTINATION}"
  "${PVPYTHON}" "${CMAKE_CURRENT_LIST_DIR}/usePlugin.py")
