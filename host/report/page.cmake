# Puts the page together from its parts: cmake -D HTML=... -D STYLE=... -D SCRIPT=... -D THREE=... -D CONTROLS=...
# -D DYGRAPHS=... -D DYGRAPHS_STYLE=... -D PAGE=... -P page.cmake
cmake_minimum_required(VERSION 3.25)
file(READ ${HTML} page)
file(READ ${DYGRAPHS_STYLE} dygraphs_style)
file(READ ${STYLE} style)
string(REPLACE "@style@" "${dygraphs_style}\n${style}" page "${page}")
foreach(part IN ITEMS THREE CONTROLS DYGRAPHS SCRIPT)
  file(READ ${${part}} text)
  string(TOLOWER ${part} name)
  string(REGEX REPLACE "//# sourceMappingURL=[^\n]*" "" text "${text}") # whoever debugs the page must ask for no file
  if(text MATCHES "</[Ss][Cc][Rr][Ii][Pp][Tt]")
    message(FATAL_ERROR "${${part}} would end the script that it stands in.")
  endif()
  string(REPLACE "@${name}@" "${text}" page "${page}")
endforeach()
file(WRITE ${PAGE} "${page}")
