// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailPoseSource
 * @brief   the pose of one bone for vtkChainMailDeformation, as a box with handles gives it
 *
 * A bone moves from x to Target + R (x - Position), where R is the rotation by the angles of Rotation. This is the
 * vtkTransform of Translate(Target), RotateZ, RotateX, RotateY and Translate(-Position), in this order. So a box widget
 * that is placed around the bone shifted by -Position has Target as its position and Rotation as its orientation.
 *
 * The output is that of a vtkChainMailProbeSource with Turns on, to be connected to the `Probes` input. Only Rotation
 * differs: it is a rotation vector in that source. About a single world axis both are the same. GetProbeRotation()
 * gives the vector.
 */

#ifndef vtkChainMailPoseSource_h
#define vtkChainMailPoseSource_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkPolyDataAlgorithm.h"

class CHAINMAILFILTERS_EXPORT vtkChainMailPoseSource : public vtkPolyDataAlgorithm
{
public:
  static vtkChainMailPoseSource* New();
  vtkTypeMacro(vtkChainMailPoseSource, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The point at rest about which the bone rotates [mm]; with Body -1 it also has to be in the bone. Default: 0 0 0.
   */
  vtkSetVector3Macro(Position, double);
  vtkGetVector3Macro(Position, double);
  ///@}

  ///@{
  /**
   * Where Position goes [mm]. Default: 0 0 0.
   */
  vtkSetVector3Macro(Target, double);
  vtkGetVector3Macro(Target, double);
  ///@}

  ///@{
  /**
   * The angles [degrees] about the world's axes x, y and z, as those of ParaView's transforms: R = RotateZ RotateX
   * RotateY. An angle about a single axis may be of any size, also more than 360. The bone takes other rotations the
   * short way, by at most 180 degrees. Default: 0 0 0.
   */
  vtkSetVector3Macro(Rotation, double);
  vtkGetVector3Macro(Rotation, double);
  ///@}

  ///@{
  /**
   * Label of the filter's BodyArray whose voxels are the bone; -1: the bone that is at Position. Default: -1.
   */
  vtkSetMacro(Body, vtkIdType);
  vtkGetMacro(Body, vtkIdType);
  ///@}

  /// Rotation as a vector along its axis, as long as the angle [degrees], as in the output.
  void GetProbeRotation(double vector[3]) const;

protected:
  vtkChainMailPoseSource();
  ~vtkChainMailPoseSource() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkChainMailPoseSource(const vtkChainMailPoseSource&) = delete;
  void operator=(const vtkChainMailPoseSource&) = delete;

  double Position[3] = { 0.0, 0.0, 0.0 };
  double Target[3] = { 0.0, 0.0, 0.0 };
  double Rotation[3] = { 0.0, 0.0, 0.0 };
  vtkIdType Body = -1;
};

#endif
