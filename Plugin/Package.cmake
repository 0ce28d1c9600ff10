# The Debian package: `cpack` in the build folder makes chainmail_<version>_<architecture>.deb, for the Debian whose
# ParaView the plugin was built with.

find_program(CHAINMAIL_DPKG_SHLIBDEPS dpkg-shlibdeps)
mark_as_advanced(CHAINMAIL_DPKG_SHLIBDEPS)
if (NOT CHAINMAIL_DPKG_SHLIBDEPS OR NOT ParaView_PREFIX_PATH STREQUAL "/usr")
  message(STATUS "No Debian package can be made: that takes dpkg-shlibdeps (from dpkg-dev) and Debian's own ParaView")
  return ()
endif ()

set(series "${ParaView_VERSION_MAJOR}.${ParaView_VERSION_MINOR}")
math(EXPR next "${ParaView_VERSION_MINOR} + 1")

# ParaView reads lists of plugins that a file paraview.conf names. Debian 13 has one, which names a further list for
# packages such as this one. Debian 12 has none and looks for it beside the program; without it not even ParaView's own
# plugins are listed, so ours names both lists.
set(folder "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/${PARAVIEW_PLUGIN_SUBDIR}")
set(lists "")
if (EXISTS "${folder}/../paraview.conf")
  file(STRINGS "${folder}/../paraview.conf" lists)
endif ()
if ("/usr/share/paraview/plugins" IN_LIST lists)
  set(listFile share/paraview/plugins)
  set(list "<Plugins>
  <Plugin name=\"ChainMail\" filename=\"/usr/${CHAINMAIL_PLUGIN_DESTINATION}/ChainMail/ChainMail.so\" auto_load=\"1\"/>
</Plugins>\n")
else ()
  set(listFile bin/paraview.conf)
  set(list "../${CHAINMAIL_PLUGIN_DESTINATION}/ChainMail.xml\n${folder}/paraview.plugins.xml\n")
endif ()
file(WRITE "${PROJECT_BINARY_DIR}/package/${listFile}" "${list}")
install(DIRECTORY "${PROJECT_BINARY_DIR}/package/" DESTINATION . COMPONENT Package EXCLUDE_FROM_ALL)
install(FILES LICENSE DESTINATION share/doc/chainmail RENAME copyright COMPONENT Package EXCLUDE_FROM_ALL)

# What to read after the installation, with the pages, pictures and scripts that it names, as they lie in the source.
install(FILES Plugin/README.Debian README.md DESTINATION share/doc/chainmail COMPONENT Package EXCLUDE_FROM_ALL)
install(DIRECTORY Data/ DESTINATION share/doc/chainmail/Data COMPONENT Package EXCLUDE_FROM_ALL FILES_MATCHING PATTERN "*.md"
  PATTERN "*.png" PATTERN "main_job.py" PATTERN "find_scene.py" PATTERN "make_forearm.py"
  PATTERN Baselines EXCLUDE PATTERN __pycache__ EXCLUDE)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME chainmail)
set(CPACK_PACKAGE_CONTACT "The ChainMail authors <chainmail@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};ChainMail;ALL;/" "${PROJECT_BINARY_DIR};ChainMail;Package;/")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE "1+paraview${series}")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "deform volumes like tissue in ParaView")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Grab a scan, pull it, cut it: heterogeneous ChainMail on OpenCL devices, as a plugin for
 ParaView, a module for VTK and an engine in C++ that needs neither.")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}")
set(CPACK_DEBIAN_PACKAGE_DEPENDS "paraview (>= ${series}), paraview (<< ${ParaView_VERSION_MAJOR}.${next}~)")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "pocl-opencl-icd | opencl-icd, python3-paraview")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
set(CHAINMAIL_PACKAGE ON) # for the tests
