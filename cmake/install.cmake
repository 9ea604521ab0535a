# What `cmake --install` writes, in components that packages are made of. Everything is found relative to the program, so the
# whole may be moved:
#
#   bin/             bipc, bipc-lsp, certcheck
#   lib/bipc/        the plug-ins (JIT; component distributed: the network; components ros1 and ros2: ROS), the runtime that `bipc build` links, and what `--serve` adds
#   share/bipc/      runtime (sources for `bipc emit`), stdlib, models
#   share/doc/bipc/  documents and licence; man pages and completions are where programs look for them
#   include/bip/, lib*/   component dev: headers and libbip_runtime.a; component libs: libbip_runtime.so.0; components compiler and compiler_dev:
#                    libbip_compiler.so.0; component python: the package bipc
include(GNUInstallDirs)
set(bipc_share ${CMAKE_INSTALL_DATADIR}/bipc)
# Not lib/<triplet>: the program looks for it at ../lib/bipc.
set(bipc_lib lib/bipc)

# tools/package puts shared libraries into lib/bipc of its archive. DT_RPATH, not DT_RUNPATH: it also holds for libraries
# of libraries. It holds in the build, too: CMake would keep its place with colons, and an empty part of it is the current
# directory, where a stranger's library would be loaded.
foreach(program bipc bipc-lsp certcheck)
  if(TARGET ${program})
    set_target_properties(${program} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "$ORIGIN/../lib/bipc:$ORIGIN/../lib")
    target_link_options(${program} PRIVATE -Wl,--disable-new-dtags)
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT bipc)
  endif()
endforeach()
function(bip_install_plugin name component)
  if(TARGET ${name})
    set_target_properties(${name} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "$ORIGIN")
    target_link_options(${name} PRIVATE -Wl,--disable-new-dtags)
    install(TARGETS ${name} LIBRARY DESTINATION ${bipc_lib} COMPONENT ${component})
  endif()
endfunction()
bip_install_plugin(bipc_jit bipc)
# Components of their own, for the libraries behind them are many: libzmq's; OpenSSL and iceoryx behind libddsc; Boost and
# log4cxx behind roscpp.
bip_install_plugin(bipc_zmq distributed)
bip_install_plugin(bipc_dds ros2)
bip_install_plugin(bipc_ros1 ros1)
install(FILES $<TARGET_FILE:bip_runtime> $<TARGET_FILE:bip_serve> DESTINATION ${bipc_lib} COMPONENT bipc)
install(DIRECTORY runtime DESTINATION ${bipc_share} COMPONENT bipc FILES_MATCHING PATTERN *.hpp PATTERN *.h PATTERN *.cpp)
# The licence stands beside the runtime's sources, wherever `bipc emit` copies them.
install(FILES LICENSE DESTINATION ${bipc_share}/runtime COMPONENT bipc)
install(DIRECTORY stdlib models DESTINATION ${bipc_share} COMPONENT bipc USE_SOURCE_PERMISSIONS PATTERN __pycache__ EXCLUDE)
install(DIRECTORY compiler/docs grammar DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT bipc)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT bipc)

install(DIRECTORY runtime/include/bip DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev FILES_MATCHING PATTERN *.hpp PATTERN *.h)
install(TARGETS bip_runtime ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
if(TARGET bip_runtime_shared)
  install(TARGETS bip_runtime_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libs NAMELINK_COMPONENT dev)
endif()

# The compiler as a library, and Python's module over it.
if(TARGET bip_compiler)
  install(DIRECTORY compiler/library/include/bip DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT compiler_dev FILES_MATCHING PATTERN *.hpp PATTERN *.h)
  # In a wheel the libraries of others are beside it.
  set_target_properties(bip_compiler PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH "$ORIGIN")
  target_link_options(bip_compiler PRIVATE -Wl,--disable-new-dtags)
  install(TARGETS bip_compiler LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT compiler NAMELINK_COMPONENT compiler_dev)
endif()
if(TARGET bipc_python)
  set(bipc_python_folder lib/python3/dist-packages/bipc CACHE STRING "Where the Python package is installed, below the prefix")
  install(DIRECTORY tools/python/bipc/ DESTINATION ${bipc_python_folder} COMPONENT python FILES_MATCHING PATTERN *.py PATTERN *.pyi PATTERN py.typed PATTERN __pycache__ EXCLUDE)
  install(TARGETS bipc_python LIBRARY DESTINATION ${bipc_python_folder} COMPONENT python)
endif()
# models/dala talks to a served model.
install(FILES tools/python/bipc/serve.py DESTINATION ${bipc_share}/tools RENAME serve_client.py COMPONENT bipc)

# find_package(bip) and pkg-config.
include(CMakePackageConfigHelpers)
set(bip_cmake ${CMAKE_INSTALL_LIBDIR}/cmake/bip)
configure_package_config_file(cmake/bipConfig.cmake.in ${PROJECT_BINARY_DIR}/bipConfig.cmake INSTALL_DESTINATION ${bip_cmake}
                              PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_BINDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/bipConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/bipConfig.cmake ${PROJECT_BINARY_DIR}/bipConfigVersion.cmake cmake/bip_add_model.cmake
        DESTINATION ${bip_cmake} COMPONENT dev)
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig OUTPUT_VARIABLE pc_prefix)
configure_file(cmake/bip-runtime.pc.in ${PROJECT_BINARY_DIR}/bip-runtime.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/bip-runtime.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

# Completions are printed by the program itself, man pages by help2man where it is installed.
set(completions ${PROJECT_BINARY_DIR}/completions)
add_custom_command(
  OUTPUT ${completions}/bipc ${completions}/_bipc ${completions}/bipc.fish
  COMMAND ${CMAKE_COMMAND} -E make_directory ${completions}
  COMMAND $<TARGET_FILE:bipc> completion bash > ${completions}/bipc
  COMMAND $<TARGET_FILE:bipc> completion zsh > ${completions}/_bipc
  COMMAND $<TARGET_FILE:bipc> completion fish > ${completions}/bipc.fish
  DEPENDS bipc
  COMMENT "Completions of bash, zsh and fish")
add_custom_target(bipc_completions ALL DEPENDS ${completions}/bipc)
install(FILES ${completions}/bipc DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT bipc)
install(FILES ${completions}/_bipc DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT bipc)
install(FILES ${completions}/bipc.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT bipc)

option(BIPC_MAN "Make man pages with help2man" OFF)
if(BIPC_MAN)
  find_program(HELP2MAN help2man REQUIRED)
  set(man_pages "")
  # certcheck is kept as short as can be, so it has no --help to make a page of.
  configure_file(cmake/certcheck.1.in ${PROJECT_BINARY_DIR}/man/certcheck.1 @ONLY)
  foreach(program bipc bipc-lsp)
    if(TARGET ${program})
      set(page ${PROJECT_BINARY_DIR}/man/${program}.1)
      add_custom_command(
        OUTPUT ${page}
        COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
        COMMAND ${CMAKE_COMMAND} -DHELP2MAN=${HELP2MAN} -DPROGRAM=$<TARGET_FILE:${program}> -DPAGE=${page}
                -DVERSION=${PROJECT_VERSION} -P ${PROJECT_SOURCE_DIR}/cmake/man_page.cmake
        DEPENDS ${program} ${PROJECT_SOURCE_DIR}/cmake/man_page.cmake
        COMMENT "Man page of ${program}")
      list(APPEND man_pages ${page})
    endif()
  endforeach()
  add_custom_target(bipc_man ALL DEPENDS ${man_pages})
  # A page for each command of bipc comes with its own.
  install(DIRECTORY ${PROJECT_BINARY_DIR}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT bipc FILES_MATCHING PATTERN *.1)
endif()
