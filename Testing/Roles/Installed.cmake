# The stand-alone project in BUILD, installed: an outside program finds it, ParaView loads the plugin from the prefix.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

set(PREFIX "${WORK}/prefix")
step("Installing" "${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${PREFIX}")
include("${CMAKE_CURRENT_LIST_DIR}/Consumer.cmake")

step("Loading the installed plugin" "${CMAKE_COMMAND}" -E env
  "PV_PLUGIN_PATH=${PREFIX}/${PLUGIN_DESTINATION}"
  "PYTHONPATH=${PREFIX}/${PYTHON_DESTINATION}"
  "${PVPYTHON}" "${CMAKE_CURRENT_LIST_DIR}/usePlugin.py")
