// SPDX-License-Identifier: BSD-3-Clause
// How a scan looks as a volume: colours and opacities that show its tissue.

#ifndef pqChainMailLook_h
#define pqChainMailLook_h

#include <string>

class QMenu;
class pqOutputPort;
class vtkSMProxy;
class vtkSMSourceProxy;

namespace pqChainMailLook
{

/// Gives a representation of an image, as a volume, colours and opacities, and shades it.
///
/// CT gets the plugin's preset of that name. An image of which nobody knows the scale, such as MR or CT in 8 bits, gets
/// "MR T1" from what its air is shown as to its brightest voxels, whatever the name: its surface is seen. Of labels all
/// but 0 is seen, in the colours that it has. Nothing happens where the plugin's presets are not there.
void Give(vtkSMProxy* representation, pqOutputPort* image, const std::string& preset);

/// Colours a volume by the scalars that a deformation smoothed (ScalarSmoothing), where it did, with the colours and
/// opacities that the scalars themselves have.
void ColourBySmoothed(vtkSMProxy* representation, vtkSMSourceProxy* deformation);

/// A menu for what is selected, in the active view: the plugin's presets, which show it as a volume. Those in
/// Hounsfield units are for CT only.
QMenu* MakeMenu();

}

#endif
