# SPDX-License-Identifier: BSD-3-Clause
# cmake -D PAGE=folder -D OUT=file.cpp -P page_files.cmake: the files of the page as a C++ source.
set(text "// Written by page_files.cmake.\n#include \"tools/web/page_files.hpp\"\n\nnamespace slam {\nnamespace {\n\n")
set(rows "")
foreach(row "/|index.html|text/html" "/words.js|words.js|text/javascript" "/german.js|german.js|text/javascript"
        "/page.js|page.js|text/javascript" "/state.js|state.js|text/javascript" "/draw.js|draw.js|text/javascript"
        "/hands.js|hands.js|text/javascript" "/maps.js|maps.js|text/javascript" "/brush.js|brush.js|text/javascript" "/edit.js|edit.js|text/javascript" "/tools.js|tools.js|text/javascript" "/logs.js|logs.js|text/javascript" "/day.js|day.js|text/javascript" "/access.js|access.js|text/javascript" "/drive.js|drive.js|text/javascript" "/commands.js|commands.js|text/javascript"
        "/setup|setup.html|text/html" "/setup.js|setup.js|text/javascript" "/setup_words.js|setup_words.js|text/javascript" "/setup.css|setup.css|text/css"
        "/worker.js|worker.js|text/javascript" "/page.css|page.css|text/css"
        "/manifest.webmanifest|manifest.webmanifest|application/manifest+json" "/icon.svg|icon.svg|image/svg+xml")
  string(REGEX MATCH "^(.*)[|](.*)[|](.*)$" matched "${row}")
  set(path ${CMAKE_MATCH_1})
  set(file ${CMAKE_MATCH_2})
  set(type "${CMAKE_MATCH_3}; charset=utf-8")
  # Indentation and lines of comment are for who reads the sources.
  file(READ ${PAGE}/${file} source)
  string(REGEX REPLACE "\n[ ]+" "\n" source "${source}")
  string(REGEX REPLACE "\n//[^\n]*" "" source "${source}")
  file(WRITE ${OUT}.part "${source}")
  file(READ ${OUT}.part hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(REGEX REPLACE "[^a-z]" "_" name ${file})
  string(APPEND text "constexpr unsigned char ${name}[] = {${bytes}};\n")
  string(APPEND rows "    {\"${path}\", \"${type}\", {reinterpret_cast<const char*>(${name}), sizeof ${name}}},\n")
endforeach()
string(APPEND text "\n}  // namespace\n\nconst PageFile* findPageFile(std::string_view path) {\n"
                   "  static const PageFile kFiles[] = {\n${rows}  };\n"
                   "  for (const PageFile& file : kFiles) {\n    if (file.path == path) return &file;\n  }\n"
                   "  return nullptr;\n}\n\n}  // namespace slam\n")
file(WRITE ${OUT} "${text}")
