// SPDX-License-Identifier: BSD-3-Clause
#ifndef ChainMailPresets_h
#define ChainMailPresets_h

#include <string>
#include <vector>

/**
 * Puts the colour and opacity presets of Plugin/Presets.json on ParaView's list, as soon as there is a session to use
 * them in. On a server this does nothing: the list belongs to the client. ParaView calls it when it loads the plugin.
 *
 * They are there as they were shipped for as long as the plugin is loaded. Whoever wants another curve saves it under a
 * name of its own.
 */
void ChainMailAddPresets();

/**
 * The names of these presets.
 */
std::vector<std::string> ChainMailPresetNames();

/**
 * Whether the preset of this name is for CT, in Hounsfield units; the others go from 0, air, to 1, the brightest.
 */
bool ChainMailPresetIsInHounsfieldUnits(const std::string& name);

#endif
