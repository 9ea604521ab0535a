# Packages of what install.cmake installs: `cpack -G DEB` in a build configured with the preset `package` (tools/package does).
#
#   bipc             programs, JIT, runtime sources, standard library, models, documents
#   bipc-distributed the network of runs on several processes
#   bipc-ros1        roscpp for bipc ros1
#   bipc-ros2        DDS for bipc ros2
#   libbip-runtime0  libbip_runtime.so.0, for programs that link it
#   bipc-dev         headers and the static library
#   libbip-compiler0, libbip-compiler-dev   the compiler as a library
#   python3-bipc     the Python package bipc, if pybind11 is installed
#   bipc-vscode      the extension as a .vsix, if tools/vscode/package made one
set(CPACK_PACKAGE_NAME bipc)
set(CPACK_PACKAGE_VENDOR "The bipc project")
# As Debian's own tools do it: who makes packages for others says who they are.
set(CPACK_PACKAGE_CONTACT "The bipc developers <bipc@localhost.localdomain>")
if(DEFINED ENV{DEBEMAIL})
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "compiler, runtime and verifier for BIP models")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL bipc libs dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY >=)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_DEBIAN_BIPC_PACKAGE_NAME bipc)
set(CPACK_DEBIAN_BIPC_PACKAGE_SECTION devel)
# `bipc build` and models with C++ need a compiler, models/dala Python.
set(CPACK_DEBIAN_BIPC_PACKAGE_RECOMMENDS "g++")
set(CPACK_DEBIAN_BIPC_PACKAGE_SUGGESTS "python3, bipc-dev, bipc-distributed, bipc-ros1, bipc-ros2, bipc-vscode, graphviz")
set(CPACK_COMPONENT_BIPC_DESCRIPTION "BIP models as programs and proofs
bipc compiles, runs and proves models written in BIP (Behaviour, Interaction,
Priority), a language for concurrent systems such as robot controllers.

The package has the compiler with interpreter and JIT, the prover, the checker
of its certificates, the language server, the standard library and examples.")

set(CPACK_DEBIAN_LIBS_PACKAGE_NAME libbip-runtime0)
set(CPACK_DEBIAN_LIBS_PACKAGE_SECTION libs)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/debian/triggers CONTENT "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBS_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_COMPONENT_LIBS_DESCRIPTION "runtime of BIP models, shared library
Executes models that bipc compiled to C++, in C++ programs (bip/bip.hpp) and
in C (bip/bip.h).")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME bipc-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libbip-runtime0 (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_DEV_DESCRIPTION "runtime of BIP models, headers and static library
For C++ and C programs that execute models which bipc compiled to C++.")

# A package bipc-COMPONENT with a plug-in, if that is built.
macro(bip_plugin_package plugin component description)
  if(TARGET ${plugin})
    string(TOUPPER ${component} name)
    list(APPEND CPACK_COMPONENTS_ALL ${component})
    set(CPACK_DEBIAN_${name}_PACKAGE_NAME bipc-${component})
    set(CPACK_DEBIAN_${name}_PACKAGE_SECTION devel)
    set(CPACK_DEBIAN_${name}_PACKAGE_DEPENDS "bipc (= ${PROJECT_VERSION})")
    set(CPACK_COMPONENT_${name}_DESCRIPTION "${description}")
    list(APPEND plugin_packages ${component}:bipc-${component})
  endif()
endmacro()
bip_plugin_package(bipc_zmq distributed "runs of BIP models on several processes
The network of bipc run --engine=distributed, over ZeroMQ.")
bip_plugin_package(bipc_ros1 ros1 "robot modules in ROS 1
roscpp for bipc ros1, which connects a served functional level to ROS 1.")
bip_plugin_package(bipc_dds ros2 "robot modules in ROS 2
DDS for bipc ros2, which connects a served functional level to ROS 2.")
set(packages bipc:bipc ${plugin_packages} libs:libbip-runtime0 dev:bipc-dev vscode:bipc-vscode)
if(TARGET bip_compiler)
  list(APPEND CPACK_COMPONENTS_ALL compiler compiler_dev)
  list(APPEND packages compiler:libbip-compiler0 compiler_dev:libbip-compiler-dev)
  # The JIT, the standard library and the runtime that `bipc build` links are those of the package bipc.
  set(CPACK_DEBIAN_COMPILER_PACKAGE_NAME libbip-compiler0)
  set(CPACK_DEBIAN_COMPILER_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_COMPILER_PACKAGE_DEPENDS "bipc (= ${PROJECT_VERSION}), libbip-runtime0 (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_COMPILER_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
  set(CPACK_COMPONENT_COMPILER_DESCRIPTION "compiler and verifier of BIP models, shared library
Loads, checks, runs, explores and proves models inside a C++ program
(bip/compiler.hpp).")
  set(CPACK_DEBIAN_COMPILER_DEV_PACKAGE_NAME libbip-compiler-dev)
  set(CPACK_DEBIAN_COMPILER_DEV_PACKAGE_SECTION libdevel)
  set(CPACK_DEBIAN_COMPILER_DEV_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_COMPILER_DEV_PACKAGE_DEPENDS "libbip-compiler0 (= ${PROJECT_VERSION}), bipc-dev (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_COMPILER_DEV_DESCRIPTION "compiler and verifier of BIP models, header
For C++ programs that load, check, run, explore and prove BIP models.")
endif()
if(TARGET bipc_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  list(APPEND packages python:python3-bipc)
  # A module of C++ belongs to one version of Python.
  get_target_property(python_suffix bipc_python SUFFIX)
  string(REGEX REPLACE "^\\.cpython-3([0-9]+).*" "\\1" python_minor "${python_suffix}")
  math(EXPR python_after "${python_minor} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-bipc)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "libbip-compiler0 (= ${PROJECT_VERSION}), python3 (>= 3.${python_minor}), python3 (<< 3.${python_after})")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-numpy, python3-pandas")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "BIP models in Python
Loads, checks, runs, explores and proves BIP models: import bipc.")
endif()
# Packages of one build depend on each other's libraries, which no package of the system has.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})

# Debian wants copyright and change log in each package's own folder.
string(TIMESTAMP year "%Y" UTC)
string(TIMESTAMP today "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(documents ${PROJECT_BINARY_DIR}/debian)
file(CONFIGURE OUTPUT ${documents}/changelog.Debian CONTENT
"bipc (${PROJECT_VERSION}) unstable; urgency=medium

  * See CHANGELOG.md.

 -- ${CPACK_PACKAGE_CONTACT}  ${today}
")
file(CONFIGURE OUTPUT ${documents}/copyright.head CONTENT
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: bipc

Files: *
Copyright: ${year} The bipc developers
License: Apache-2.0 WITH LLVM-exception

License: Apache-2.0 WITH LLVM-exception
 The Apache License, Version 2.0, is in /usr/share/common-licenses/Apache-2.0 on
 Debian systems.
")
# Compressed when a package is made: the time stamp would change the file at each configuration.
find_program(GZIP gzip REQUIRED)
configure_file(cmake/debian_documents.cmake.in ${documents}/documents.cmake @ONLY)
foreach(pair ${packages})
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 component)
  list(GET pair 1 package)
  install(CODE "set(package ${package})\ninclude(\"${documents}/documents.cmake\")" COMPONENT ${component})
endforeach()

set(vsix ${PROJECT_SOURCE_DIR}/tools/vscode/bip.vsix)
if(EXISTS ${vsix})
  list(APPEND CPACK_COMPONENTS_ALL vscode)
  install(FILES ${vsix} DESTINATION ${CMAKE_INSTALL_DATADIR}/bipc-vscode COMPONENT vscode)
  set(CPACK_DEBIAN_VSCODE_PACKAGE_NAME bipc-vscode)
  set(CPACK_DEBIAN_VSCODE_PACKAGE_SECTION editors)
  set(CPACK_DEBIAN_VSCODE_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_VSCODE_PACKAGE_SHLIBDEPS OFF)
  set(CPACK_DEBIAN_VSCODE_PACKAGE_DEPENDS "bipc (>= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_VSCODE_DESCRIPTION "BIP in Visual Studio Code
The extension that starts bipc's language server, as a .vsix file:
code --install-extension /usr/share/bipc-vscode/bip.vsix")
endif()
if(PROJECT_IS_TOP_LEVEL)
  include(CPack)
endif()
