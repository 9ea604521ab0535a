# Packages of what install.cmake installs: `cpack -G DEB` in a build configured with the preset `package` (tools/package does).
#
#   bipc             programs, JIT, runtime sources, standard library, models, documents
#   libbip-runtime0  libbip_runtime.so.0, for programs that link it
#   bipc-dev         headers and the static library
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
set(CPACK_DEBIAN_BIPC_PACKAGE_SUGGESTS "python3, bipc-dev, bipc-vscode, graphviz")
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
foreach(pair bipc:bipc libs:libbip-runtime0 dev:bipc-dev vscode:bipc-vscode)
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
