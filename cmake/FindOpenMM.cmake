# FindOpenMM: the imported target OpenMM::OpenMM, from the OpenMM wheel or any OpenMM installation.
#
# OPENMM_DIR names the folder that holds include/ and lib/. Where it is not set, Python is asked:
# ${Python_EXECUTABLE}, or the one that CMake finds; its OpenMM has to be 8.6.x. (The headers do not
# tell their version; the Python package asks the library when it loads the plugin.) Nothing is
# cached, since an isolated build has its OpenMM in another place each time.

if(NOT OPENMM_DIR)
  if(NOT Python_EXECUTABLE)
    find_package(Python COMPONENTS Interpreter QUIET)
  endif()
  execute_process(
    COMMAND ${Python_EXECUTABLE} -c
            "import openmm.version as v; print(v.openmm_library_path + ';' + v.short_version)"
    OUTPUT_VARIABLE openmm_answer OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(openmm_answer)
    list(GET openmm_answer 0 openmm_library_dir)
    list(GET openmm_answer 1 OpenMM_VERSION)
    get_filename_component(OPENMM_DIR "${openmm_library_dir}" DIRECTORY)
    if(NOT OpenMM_VERSION MATCHES "^8\\.6(\\.|$)")
      message(FATAL_ERROR "OpenMM 8.6 is needed; ${Python_EXECUTABLE} has ${OpenMM_VERSION}.")
    endif()
  endif()
endif()

find_path(OpenMM_INCLUDE_DIR OpenMM.h HINTS "${OPENMM_DIR}/include" NO_DEFAULT_PATH NO_CACHE)
find_library(OpenMM_LIBRARY OpenMM HINTS "${OPENMM_DIR}/lib" NO_DEFAULT_PATH NO_CACHE)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenMM REQUIRED_VARS OpenMM_LIBRARY OpenMM_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "Install it (pip install 'openmm>=8.6,<8.7') or set OPENMM_DIR.")

if(OpenMM_FOUND AND NOT TARGET OpenMM::OpenMM)
  add_library(OpenMM::OpenMM SHARED IMPORTED GLOBAL)
  # platform headers include each other by bare name
  set_target_properties(OpenMM::OpenMM PROPERTIES IMPORTED_LOCATION "${OpenMM_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenMM_INCLUDE_DIR};${OpenMM_INCLUDE_DIR}/openmm/reference")
endif()
