# Writes OUTPUT, the C++ definition of the functions in KernelSources.h, from the OpenCL files in SOURCES (joined by
# "|"). Run at build time with cmake -P, so that an edited kernel is embedded again.
#
# Every line becomes a raw literal of its own and the compiler joins them: no literal comes near a compiler's limit.
# The text begins with #line, so that messages of the OpenCL compiler name the file and line that a developer edits.

cmake_minimum_required(VERSION 3.18)

string(REPLACE "|" ";" SOURCES "${SOURCES}")
set(table "")
set(names "")
foreach (source IN LISTS SOURCES)
  get_filename_component(name "${source}" NAME)
  if (name IN_LIST names)
    message(FATAL_ERROR "There are two files ${name}")
  endif ()
  list(APPEND names "${name}")
  file(READ "${source}" text)
  if (text MATCHES "\\)~\"")
    message(FATAL_ERROR "${source} holds the characters )~\" that end an embedded line")
  endif ()
  string(REPLACE "\n" "\n)~\"\n    R\"~(" text "${text}")
  string(APPEND table "  if (fileName == \"${name}\")\n    return R\"~(#line 1 \"${name}\"\n)~\"\n    R\"~(${text})~\";\n")
endforeach ()

string(SHA256 hash "${table}")
list(JOIN names "\", \"" names)
file(WRITE "${OUTPUT}" "// Made from the OpenCL files of Kernels by EmbedSources.cmake.
#include \"KernelSources.h\"

namespace chainmail::detail
{

const char* kernelSource(const std::string& fileName)
{
${table}  return nullptr;
}

std::vector<std::string> kernelFiles()
{
  return { \"${names}\" };
}

const char* kernelsHash()
{
  return \"${hash}\";
}

}
")
