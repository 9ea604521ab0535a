# Writes the files of page/ as one .cpp of raw string literals. Called by the build with -DPAGE=folder -DOUT=file.
set(text "// Generated from compiler/view/page by embed_page.cmake.\n#include \"compiler/view/page_files.hpp\"\n\nnamespace bip::view {\n\n")
foreach(file page.html page.css run.js picture.js charts.js steps.js proof.js connection.js live.js attached.js page.js)
  file(READ "${PAGE}/${file}" body)
  string(REPLACE "." "_" name "${file}")
  # A literal may have 65,536 bytes.
  string(APPEND text "const std::string_view k_${name} = R\"~page~(${body})~page~\";\n")
endforeach()
string(APPEND text "\n}  // namespace bip::view\n")
file(WRITE "${OUT}" "${text}")
