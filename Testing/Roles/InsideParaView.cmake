# A folder inside ParaView's own build: a small project that finds and builds plugins with ParaView's own calls.
include("${CMAKE_CURRENT_LIST_DIR}/Steps.cmake")

file(COPY "${CMAKE_CURRENT_LIST_DIR}/InsideParaView/" DESTINATION "${WORK}/ParaView")
copy_repository("${WORK}/ParaView/Plugins/ChainMail")
configure("${WORK}/ParaView" "${WORK}/build" "-DParaView_DIR=${ParaView_DIR}")
build("${WORK}/build")
file(STRINGS "${WORK}/build/plugins.txt" plugins)
step("Loading the plugin" "${CMAKE_COMMAND}" -E env "PV_PLUGIN_PATH=${plugins}"
  "${PVPYTHON}" "${CMAKE_CURRENT_LIST_DIR}/usePlugin.py")
