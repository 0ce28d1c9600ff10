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
foreach (part "paraview \\(>= 5" "paraview \\(<< 5" "libc6 " "ocl-icd-libopencl1" "Recommends:.*pocl-opencl-icd \\| opencl-icd")
  if (NOT output MATCHES "${part}")
    message(FATAL_ERROR "The package does not ask for ${part}: ${output}")
  endif ()
endforeach ()

step("Unpacking it" dpkg-deb --extract "${packages}" "${WORK}/root")
file(GLOB_RECURSE files RELATIVE "${WORK}/root/usr" "${WORK}/root/*")
foreach (part "^${PLUGIN_DESTINATION}/ChainMail/ChainMail.so$" "^${PYTHON_DESTINATION}/chainmail/ChainMailFilters.*so$"
    "^include/ChainMail/vtkChainMailDeformation.h$" "^include/ChainMail/Kernels/Simulation.h$" "/ChainMailConfig.cmake$"
    "^share/ChainMail/Presets.json$" "^share/doc/chainmail/copyright$")
  set(found ${files})
  list(FILTER found INCLUDE REGEX "${part}")
  if (NOT found)
    message(FATAL_ERROR "The package has no ${part}: ${files}")
  endif ()
endforeach ()

# The lists of plugins that it tells ParaView of: its own, and ParaView's where the package goes to.
file(STRINGS "${WORK}/root/usr/bin/paraview.conf" lists)
list(LENGTH lists count)
list(GET lists 0 ours)
list(GET lists 1 theirs)
if (NOT count EQUAL 2 OR NOT EXISTS "/usr/bin/${theirs}" OR NOT EXISTS "${WORK}/root/usr/bin/${ours}")
  message(FATAL_ERROR "paraview.conf names lists of plugins that are not there: ${lists}")
endif ()
step("Loading the plugin from its files" "${CMAKE_COMMAND}" -E env --unset=PV_PLUGIN_PATH
  "PV_PLUGIN_CONFIG_FILE=${WORK}/root/usr/bin/${ours}"
  "PYTHONPATH=${WORK}/root/usr/${PYTHON_DESTINATION}"
  "${PVPYTHON}" "${CMAKE_CURRENT_LIST_DIR}/usePlugin.py")
