// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailProbeSource
 * @brief   one probe for vtkChainMailDeformation
 *
 * The output is one point at Position, with a vertex so that it can be seen, and with the point arrays that
 * vtkChainMailDeformation reads from its `Probes` input: `Displacement` (3 doubles, Target - Position), `Radius` (1
 * double), `Anchor` (1 unsigned char, 0 or 1) and `Tolerance` (1 double). For several probes, connect several sources
 * to the same port. Lengths are in the physical units of the image (mm for medical data), in world axes. As with any
 * VTK algorithm, one thread at a time may use a source.
 */

#ifndef vtkChainMailProbeSource_h
#define vtkChainMailProbeSource_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

class CHAINMAILFILTERS_EXPORT vtkChainMailProbeSource : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailProbeSource* New();
  vtkTypeMacro(vtkChainMailProbeSource, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The place where tissue is grabbed [mm]: the tissue that rests there or, with MODE_INTERACTIVE, the tissue that is
   * there when the probe appears. Default: 0 0 0.
   */
  vtkSetVector3Macro(Position, double);
  vtkGetVector3Macro(Position, double);
  ///@}

  ///@{
  /**
   * The place to which the tissue at Position is dragged [mm]. An anchor does not use it. Default: 0 0 0.
   */
  vtkSetVector3Macro(Target, double);
  vtkGetVector3Macro(Target, double);
  ///@}

  ///@{
  /**
   * Elements within this distance of Position move together [mm], [0, VTK_DOUBLE_MAX]; 0: the nearest element alone.
   * Default: 0.
   */
  vtkSetClampMacro(Radius, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Radius, double);
  ///@}

  ///@{
  /**
   * Hold the tissue where it is instead of moving it. Default: off.
   */
  vtkSetMacro(Anchor, bool);
  vtkGetMacro(Anchor, bool);
  vtkBooleanMacro(Anchor, bool);
  ///@}

  ///@{
  /**
   * How near tissue has to come to Target [mm], [0, VTK_DOUBLE_MAX]. 0: exactly, as far as it stretches. Above 0 the
   * probe is soft: relaxation weighs the distance to Target against the tissue's energy (Data/Bones.md). Default: 0.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * Also rotate what is grabbed, by Rotation about Position. The probe then grips the whole bone of each rigid element
   * that it grabs, and the bone reaches exactly this pose. Adds the point array `Rotation`. Needs Rotations of the
   * filter. Default: off.
   */
  vtkSetMacro(Turns, bool);
  vtkGetMacro(Turns, bool);
  vtkBooleanMacro(Turns, bool);
  ///@}

  ///@{
  /**
   * The rotation vector: along the axis, in world axes, its length the angle [degrees], of any size. Default: 0 0 0.
   */
  vtkSetVector3Macro(Rotation, double);
  vtkGetVector3Macro(Rotation, double);
  ///@}

  ///@{
  /**
   * Label of the filter's BodyArray whose voxels are gripped instead of the tissue at Position; -1: the tissue at
   * Position. Other than -1 it adds the point array `Body`. Default: -1.
   */
  vtkSetMacro(Body, vtkIdType);
  vtkGetMacro(Body, vtkIdType);
  ///@}

protected:
  vtkChainMailProbeSource();
  ~vtkChainMailProbeSource() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailProbeSource(const vtkChainMailProbeSource&) = delete;
  void operator=(const vtkChainMailProbeSource&) = delete;

  double Position[3] = { 0.0, 0.0, 0.0 };
  double Target[3] = { 0.0, 0.0, 0.0 };
  double Radius = 0.0;
  bool Anchor = false;
  bool Turns = false;
  double Rotation[3] = { 0.0, 0.0, 0.0 };
  vtkIdType Body = -1;
  double Tolerance = 0.0;
};

#endif
