# cmake -DOUT=texts.cpp -DLANGUAGES="en.toml;de.toml" -P embed_languages.cmake: checks the languages' files against the
# English one and embeds their texts. A file has `name` and `place`, sections, and entries of one line: key = "text".
cmake_minimum_required(VERSION 3.25)

set(problems "")
function(problem text)
  set(problems "${problems}\n  ${text}" PARENT_SCOPE)
endfunction()

# text_CODE_KEY and holes_CODE_KEY (its placeholders, sorted) of each entry, keys_CODE, name_CODE, place_CODE.
function(read_language file code)
  file(READ ${file} rest)
  set(section "")
  set(keys "")
  set(number 0)
  while(NOT rest STREQUAL "")
    math(EXPR number "${number} + 1")
    string(FIND "${rest}" "\n" end)
    if(end EQUAL -1)
      set(line "${rest}")
      set(rest "")
    else()
      string(SUBSTRING "${rest}" 0 ${end} line)
      math(EXPR end "${end} + 1")
      string(SUBSTRING "${rest}" ${end} -1 rest)
    endif()
    if(line MATCHES "^[ \t\r]*(#.*)?$")
    elseif(line MATCHES "^\\[([a-z.-]+)\\][ \r]*$")
      set(section "${CMAKE_MATCH_1}.")
    elseif(line MATCHES "^place = ([0-9]+)[ \r]*(#.*)?$" AND section STREQUAL "")
      set(place_${code} ${CMAKE_MATCH_1} PARENT_SCOPE)
    elseif(line MATCHES "^([a-z_-]+) = \"(.*)\"[ \r]*$")
      set(key "${section}${CMAKE_MATCH_1}")
      set(text "${CMAKE_MATCH_2}")
      string(REGEX REPLACE "\\\\(n|\"|\\\\|u[0-9A-Fa-f][0-9A-Fa-f][0-9A-Fa-f][0-9A-Fa-f])" "" plain "${text}")
      string(REGEX MATCHALL "{[a-z]+}" holes "${text}")
      string(REGEX REPLACE "{[a-z]+}" "" unheld "${text}")
      list(SORT holes)
      list(JOIN holes ", " holes)
      if(holes STREQUAL "")
        set(holes "none")
      endif()
      if(text STREQUAL "")
        problem("${file}: ${key}: empty; expected a text")
      elseif(plain MATCHES "[\"\\]")
        problem("${file}: ${key}: expected quotes and backslashes as \\\" and \\\\, and of other escapes \\n and \\u202F only")
      elseif(unheld MATCHES "[{}]")
        problem("${file}: ${key}: expected braces around a placeholder's name only, such as {count}")
      elseif(DEFINED found_${key})
        problem("${file}: ${key}: stands there twice")
      endif()
      set(found_${key} YES)
      if(key STREQUAL "name")
        set(name_${code} "${text}" PARENT_SCOPE)
      else()
        list(APPEND keys ${key})
        set("text_${code}_${key}" "${text}" PARENT_SCOPE)
        set("holes_${code}_${key}" "${holes}" PARENT_SCOPE)
      endif()
    else()
      problem("${file}: line ${number}: expected [section], key = \"text\" or a comment, not: ${line}")
    endif()
  endwhile()
  list(SORT keys)
  set(keys_${code} "${keys}" PARENT_SCOPE)
  set(problems "${problems}" PARENT_SCOPE)
endfunction()

set(codes "")
set(order "")
foreach(file ${LANGUAGES})
  cmake_path(GET file STEM code)
  if(NOT code MATCHES "^[a-z][a-z][a-z]?$")
    problem("${file}: expected the file to be named by the language's code of ISO 639, such as nl.toml")
    continue()
  endif()
  set(file_${code} ${file})
  read_language(${file} ${code})
  list(APPEND codes ${code})
  foreach(what name place)
    if(NOT DEFINED ${what}_${code})
      problem("${file}: ${what}: missing; expected above the first section: name = \"Nederlands\" and place = 7")
    endif()
  endforeach()
  list(APPEND order "${place_${code}}/${code}")
endforeach()
if(NOT "en" IN_LIST codes)
  message(FATAL_ERROR "en.toml is missing among ${LANGUAGES}: expected English, which the others are compared with")
endif()

foreach(code ${codes})
  foreach(key ${keys_en})
    if(NOT DEFINED "text_${code}_${key}")
      problem("${file_${code}}: ${key}: missing; en.toml has \"${text_en_${key}}\"")
    elseif(NOT "${holes_${code}_${key}}" STREQUAL "${holes_en_${key}}")
      problem("${file_${code}}: ${key}: has the placeholders ${holes_${code}_${key}}; en.toml has ${holes_en_${key}}")
    endif()
  endforeach()
  foreach(key ${keys_${code}})
    if(NOT DEFINED "text_en_${key}")
      problem("${file_${code}}: ${key}: en.toml has no such entry; expected its keys only")
    endif()
  endforeach()
endforeach()
if(problems)
  message(FATAL_ERROR "Translations:${problems}")
endif()

# English first: what is shown where nothing is configured.
list(SORT order COMPARE NATURAL)
list(TRANSFORM order REPLACE "^.*/" "")
list(REMOVE_ITEM order en)
list(PREPEND order en)
set(keys "")
set(tables "")
set(languages "")
foreach(key ${keys_en})
  string(APPEND keys "    \"${key}\",\n")
endforeach()
foreach(code ${order})
  string(APPEND tables "constexpr std::string_view k_${code}[] = {\n")
  foreach(key ${keys_en})
    string(APPEND tables "    \"${text_${code}_${key}}\",\n")
  endforeach()
  string(APPEND tables "};\n")
  string(APPEND languages "    {\"${code}\", \"${name_${code}}\", k_${code}},\n")
endforeach()
file(WRITE ${OUT} "// Made by embed_languages.cmake from base/words/languages.
#include \"base/words/texts.hpp\"

namespace kasumi {
namespace {

constexpr std::string_view kKeys[] = {
${keys}};
${tables}constexpr LanguageTexts kLanguages[] = {
${languages}};

}  // namespace

std::span<const std::string_view> text_keys() {
  return kKeys;
}

std::span<const LanguageTexts> language_texts() {
  return kLanguages;
}

}  // namespace kasumi
")
