# FindRDKit: imported targets RDKit::GraphMol, RDKit::SmilesParse, ... for the components asked for.
#
# RDKit's own CMake package is taken where there is one (conda-forge); Debian's librdkit-dev has
# none, so that headers and libraries are looked for. RDKIT_DIR names a folder that holds
# include/rdkit and lib. RDKit's headers need Boost's (libboost-dev).

# targets that RDKit's package may refer to without looking for them
find_package(Threads QUIET)
find_package(Boost QUIET OPTIONAL_COMPONENTS serialization)
find_package(RDKit CONFIG QUIET HINTS "${RDKIT_DIR}")
if(RDKit_FOUND)
  set(rdkit_lacks "")
  foreach(component IN LISTS RDKit_FIND_COMPONENTS)
    if(NOT TARGET RDKit::${component})
      list(APPEND rdkit_lacks ${component})
    endif()
  endforeach()
  if(NOT rdkit_lacks)
    return()
  endif()
endif()

find_path(RDKit_INCLUDE_DIR GraphMol/ROMol.h HINTS "${RDKIT_DIR}/include" PATH_SUFFIXES rdkit)
find_path(RDKit_BOOST_INCLUDE_DIR boost/dynamic_bitset.hpp HINTS "${RDKIT_DIR}/include")
set(rdkit_libraries "")
foreach(component IN LISTS RDKit_FIND_COMPONENTS)
  find_library(RDKit_${component}_LIBRARY RDKit${component} HINTS "${RDKIT_DIR}/lib")
  mark_as_advanced(RDKit_${component}_LIBRARY)
  list(APPEND rdkit_libraries RDKit_${component}_LIBRARY)
endforeach()
mark_as_advanced(RDKit_INCLUDE_DIR RDKit_BOOST_INCLUDE_DIR)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(RDKit
  REQUIRED_VARS RDKit_INCLUDE_DIR RDKit_BOOST_INCLUDE_DIR ${rdkit_libraries}
  REASON_FAILURE_MESSAGE
  "Install it (apt-get install librdkit-dev libboost-dev, or conda install librdkit-dev) or set RDKIT_DIR.")

if(RDKit_FOUND)
  foreach(component IN LISTS RDKit_FIND_COMPONENTS)
    if(NOT TARGET RDKit::${component})
      add_library(RDKit::${component} UNKNOWN IMPORTED)
      set_target_properties(RDKit::${component} PROPERTIES
        IMPORTED_LOCATION "${RDKit_${component}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${RDKit_INCLUDE_DIR};${RDKit_BOOST_INCLUDE_DIR}")
    endif()
  endforeach()
endif()
