# cmake -DSOURCE=<file> -P lazy_grammar.cmake: a lexer or parser of ANTLR 4.9 or before reads its automaton when the program starts, and so
# does a program that never reads a text of that language. Its first object reads it instead, without the check of the tables that the
# ANTLR tool has just written (a third of the time). Later versions of ANTLR wait for the first object by themselves.
file(READ ${SOURCE} text)
get_filename_component(class ${SOURCE} NAME_WE)
string(FIND "${text}" "${class}::Initializer ${class}::_init;" at_start)
if(at_start EQUAL -1)
  return()
endif()
string(REPLACE "${class}::Initializer ${class}::_init;" "" text "${text}")
string(REGEX REPLACE "(\n${class}::${class}\\([A-Za-z]+ \\*input\\) : [A-Za-z]+\\(input\\) {\n)" "\\1  static const Initializer initializer;\n" changed "${text}")
if(changed STREQUAL text)
  message(FATAL_ERROR "${SOURCE}: no constructor that can read the automaton")
endif()
string(REPLACE "  atn::ATNDeserializer deserializer;\n"
       "  atn::ATNDeserializationOptions options;\n  options.setVerifyATN(false);\n  atn::ATNDeserializer deserializer(options);\n" changed "${changed}")
file(WRITE ${SOURCE} "${changed}")
