# BIPC_COMMIT: what is built, for `bipc version --json`. CMake runs again after each commit; then one small source compiles.
# A source archive has no repository: whoever builds it may say -DBIPC_COMMIT=.
set(BIPC_COMMIT "" CACHE STRING "The commit that is built; empty: ask git")
set(bipc_commit "${BIPC_COMMIT}")
find_package(Git QUIET)
if(NOT bipc_commit AND Git_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse --short=12 HEAD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE bipc_commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse --git-path logs/HEAD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE log_of_head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  cmake_path(ABSOLUTE_PATH log_of_head BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
  if(EXISTS ${log_of_head})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${log_of_head})
  endif()
endif()
