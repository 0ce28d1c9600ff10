// SPDX-License-Identifier: BSD-3-Clause
#include "ChainMailCompileAhead.h"

#include "vtkMultiProcessController.h"

#include <vtksys/Process.h>
#include <vtksys/SystemTools.hxx>

#include <cstdlib>
#include <memory>
#include <string>

#ifdef _WIN32
#include "vtkResourceFileLocator.h"
#else
#include <dlfcn.h>
#endif

namespace
{

bool isWanted()
{
  const char* cache = std::getenv("CHAINMAIL_CACHE_DIR");
  const char* wish = std::getenv("CHAINMAIL_COMPILE_AHEAD");
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  return !(cache && !*cache) && !(wish && std::string(wish) == "0") &&
         !(controller && controller->GetLocalProcessId() != 0);
}

/// The file of the plugin, which this function is part of; the program lies beside it.
std::string pluginFile()
{
#ifdef _WIN32
  return vtkGetLibraryPathForSymbol(ChainMailCompileAhead);
#else // VTK finds functions by their names there, and those of a plugin not at all
  Dl_info info;
  return dladdr(reinterpret_cast<const void*>(&ChainMailCompileAhead), &info) ? info.dli_fname : "";
#endif
}

}

//------------------------------------------------------------------------------
void ChainMailCompileAhead()
{
  if (!isWanted())
  {
    return;
  }
  const std::string program =
    vtksys::SystemTools::GetFilenamePath(pluginFile()) + "/ChainMailCompileAhead" CHAINMAIL_PROGRAM_ENDING;
  if (!vtksys::SystemTools::FileExists(program, true))
  {
    return;
  }
  const std::unique_ptr<vtksysProcess, decltype(&vtksysProcess_Delete)> process(
    vtksysProcess_New(), vtksysProcess_Delete);
  const char* const command[] = { program.c_str(), nullptr };
  vtksysProcess_SetCommand(process.get(), command);
  vtksysProcess_SetOption(process.get(), vtksysProcess_Option_Detach, 1); // it may outlive this process
  vtksysProcess_SetOption(process.get(), vtksysProcess_Option_HideWindow, 1);
#ifdef _WIN32
  const char* const nowhere = "NUL";
#else
  const char* const nowhere = "/dev/null";
#endif
  vtksysProcess_SetPipeFile(process.get(), vtksysProcess_Pipe_STDOUT, nowhere);
  vtksysProcess_SetPipeFile(process.get(), vtksysProcess_Pipe_STDERR, nowhere);
  vtksysProcess_Execute(process.get());
  vtksysProcess_Disown(process.get());
}
