// SPDX-License-Identifier: BSD-3-Clause
#include "ChainMailPresets.h"

#include "ChainMailPresetsJSON.h" // made from Plugin/Presets.json

#include "vtkCallbackCommand.h"
#include "vtkNew.h"
#include "vtkProcessModule.h"
#include "vtkSMProxyManager.h"
#include "vtkSMSettings.h"
#include "vtkSMTransferFunctionPresets.h"

#include <vtk_jsoncpp.h>

#include <memory>
#include <string>

namespace
{

unsigned long waitingForSession = 0;

Json::Value presetsOfThePlugin()
{
  const auto* text = reinterpret_cast<const char*>(ChainMailPresetsJSON);
  const std::unique_ptr<Json::CharReader> reader(Json::CharReaderBuilder().newCharReader());
  Json::Value presets;
  std::string problems;
  if (!reader->parse(text, text + sizeof ChainMailPresetsJSON, &presets, &problems))
  {
    vtkGenericWarningMacro("The presets of the ChainMail plugin cannot be read: " << problems);
  }
  return presets;
}

void addPresets()
{
  vtkSMTransferFunctionPresets* list = vtkSMTransferFunctionPresets::GetInstance();
  vtkSMSettings* settings = vtkSMSettings::GetInstance();
  // ParaView writes every preset that is added into the settings of the user, who added none.
  const char* const key = "TransferFunctionPresets.CustomPresets";
  const std::string ofTheUser = settings->GetSettingAsString(key, "");
  const Json::Value presets = presetsOfThePlugin();
  for (const Json::Value& preset : presets)
  {
    int earlier = -1; // of another version of the plugin, saved along with presets of the user
    list->GetFirstPresetWithName(preset["Name"].asCString(), earlier);
    if (earlier >= 0)
    {
      list->RemovePreset(static_cast<unsigned int>(earlier));
    }
  }
  list->ImportPresets(presets);
  settings->SetSetting(key, ofTheUser);
}

}

//------------------------------------------------------------------------------
std::vector<std::string> ChainMailPresetNames()
{
  std::vector<std::string> names;
  for (const Json::Value& preset : presetsOfThePlugin())
  {
    names.push_back(preset["Name"].asString());
  }
  return names;
}

//------------------------------------------------------------------------------
bool ChainMailPresetIsInHounsfieldUnits(const std::string& name)
{
  for (const Json::Value& preset : presetsOfThePlugin())
  {
    if (preset["Name"].asString() == name)
    {
      return preset["RGBPoints"][0].asDouble() < 0.0;
    }
  }
  return false;
}

//------------------------------------------------------------------------------
void ChainMailAddPresets()
{
  switch (vtkProcessModule::GetProcessType())
  {
  case vtkProcessModule::PROCESS_SERVER:
  case vtkProcessModule::PROCESS_DATA_SERVER:
  case vtkProcessModule::PROCESS_RENDER_SERVER:
    return;
  default:
    break;
  }
  if (vtkSMProxyManager::GetProxyManager()->GetActiveSession())
  {
    addPresets();
    return;
  }
  // ParaView loads the plugins in PV_PLUGIN_PATH before the settings, which hold the presets of the user. There is no
  // session before it has read both.
  vtkNew<vtkCallbackCommand> session;
  session->SetCallback(
    [](vtkObject* module, unsigned long, void*, void*)
    {
      module->RemoveObserver(waitingForSession);
      addPresets();
    });
  waitingForSession = vtkProcessModule::GetProcessModule()->AddObserver(vtkCommand::ConnectionCreatedEvent, session);
}
