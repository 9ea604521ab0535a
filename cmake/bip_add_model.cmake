# bip_add_model(<target> <file> [NAMESPACE <name>] [ROOT <type(arguments)>] [FOLDERS <folder>...])
#
# Adds the C++ of a BIP model to a target that is there already, and links bip::runtime. The target may have several models,
# each in a namespace of its own (default: the file's name). In C++: #include "<name>.h", then <name>::image(); in C:
# <name>_image(), which returns a `const bip_image*` for bip/bip.h. FOLDERS are searched for packages, as by -I of bipc.
# C++ that the model names with @cpp belongs to the target like any other source.
function(bip_add_model target file)
  cmake_parse_arguments(PARSE_ARGV 2 model "" "NAMESPACE;ROOT" "FOLDERS")
  if(model_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "bip_add_model: what is `${model_UNPARSED_ARGUMENTS}`?")
  endif()
  cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  if(NOT model_NAMESPACE)
    cmake_path(GET file STEM model_NAMESPACE)
  endif()
  string(REPLACE "::" "_" name ${model_NAMESPACE})
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/bip_models/${target})
  file(CONFIGURE OUTPUT ${folder}/${name}.h CONTENT
"// The model of ${name}.cpp, which bipc emitted.
#pragma once
#ifdef __cplusplus
#include \"bip/bip.hpp\"
namespace ${model_NAMESPACE} {
const bip::rt::Image& image();
}
extern \"C\" const struct bip_image* ${name}_image(void);
#else
#include \"bip/bip.h\"
const bip_image* ${name}_image(void);
#endif
")
  set(options --namespace ${model_NAMESPACE})
  if(model_ROOT)
    list(APPEND options --root ${model_ROOT})
  endif()
  # Any package of these folders may be one that the model uses.
  set(packages "")
  foreach(package_folder IN LISTS model_FOLDERS)
    cmake_path(ABSOLUTE_PATH package_folder BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
    list(APPEND options -I ${package_folder})
    file(GLOB_RECURSE found CONFIGURE_DEPENDS ${package_folder}/*.bip)
    list(APPEND packages ${found})
  endforeach()
  add_custom_command(
    OUTPUT ${folder}/${name}.cpp
    COMMAND bip::bipc emit ${options} ${file} > ${folder}/${name}.cpp
    DEPENDS ${file} ${packages} bip::bipc
    COMMENT "bipc emit ${file}"
    VERBATIM)
  target_sources(${target} PRIVATE ${folder}/${name}.cpp)
  # Floats are rounded after each operation, as in every other executor. Models do not share a source with anything.
  set_source_files_properties(${folder}/${name}.cpp PROPERTIES COMPILE_OPTIONS -ffp-contract=off SKIP_UNITY_BUILD_INCLUSION ON)
  target_include_directories(${target} PRIVATE ${folder})
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_link_libraries(${target} PRIVATE bip::runtime)
endfunction()
