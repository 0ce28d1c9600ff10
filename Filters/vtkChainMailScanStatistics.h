// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailScanStatistics
 * @brief   tells what the scalars of a scan are: Hounsfield units, labels, or numbers without a unit
 *
 * All that vtkChainMailDeformation and the plugin guess about a scan comes from here: the material that fits it, the
 * threshold of air, the value that air is shown as, and which voxels are padding. This class works on the histogram of
 * the scalars and looks at where most of them are. So a few wrong voxels, or ringing beside edges, change nothing. The
 * first rule that applies counts:
 *
 * - **Padding** is a number that means "nothing was measured here". It is set aside, and is neither air nor tissue. Low
 *   padding is a number below -1200, with more voxels than all numbers up to 200 above it. It is one of those in use
 *   (-32768, -32767, -9999, -4096, -3072, -3071, -3024, -3000, -2048, -2000), or any other if the scan without it is
 *   CT. High padding is 32767, 32768 or one of the last 4096 numbers of 16 bits, if all else is below 16384. (Without
 *   its sign -2000 is 63536.)
 * - KIND_LABELS: whole numbers from 0 up in an array of integers, with at least 2 and at most 4096 labels. Most pairs
 *   of neighbours along a row are equal, not counting pairs of zeros. Labels meet that differ by more than 1, unlike
 *   the grey values of a smooth picture. A few numbers with wide gaps, and two numbers alone (a mask), are not taken
 *   for labels.
 * - KIND_CT: at least one in a thousand voxels is air or lung (-1100 to -600). There are more of these per unit than
 *   between -500 and -250, where ringing would be, or they have a peak at air. Hardly any voxels are below. A tenth of
 *   those from -300 up is between -200 and 200, as fat, water, muscle and organs are. Or, in a crop without air, nearly
 *   all voxels are between -200 and 200, with fat and muscle in their places and next to nothing below fat.
 * - KIND_UNKNOWN: all else, such as MR, or CT that was stretched or stored in 8 bits.
 *
 * In an image of more than 2^24 voxels only every n-th row is read, so the time is bounded to some hundredths of a
 * second. An image in pieces (see Merge()) gives the same result as the whole, whatever the type of the array.
 *
 * @sa vtkChainMailDeformation
 */

#ifndef vtkChainMailScanStatistics_h
#define vtkChainMailScanStatistics_h

#include "ChainMailFiltersModule.h" // for export macro
#include "vtkObject.h"
#include "vtkSmartPointer.h" // for Of()

#include <memory> // for std::unique_ptr
#include <string> // for descriptions
#include <vector> // for Pack()

class vtkDataArray;
class vtkImageData;
class vtkPiecewiseFunction;

class CHAINMAILFILTERS_EXPORT vtkChainMailScanStatistics : public vtkObject
{
public:
  static vtkChainMailScanStatistics* New();
  vtkTypeMacro(vtkChainMailScanStatistics, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum Kinds
  {
    KIND_UNKNOWN = 0,
    KIND_CT = 1,
    KIND_LABELS = 2
  };

  /// Reads the first component of a point array of the image.
  void Read(vtkImageData* image, vtkDataArray* scalars);

  /// Reads a part of an image whose whole extent is `whole`. Voxels that several parts share count once.
  void ReadPart(vtkImageData* part, vtkDataArray* scalars, const int whole[6]);

  /// Adds what `other` has read of another part of the same image. If one of the two has read the whole image, its
  /// result replaces that of the other.
  void Merge(vtkChainMailScanStatistics* other);

  /// The statistics as numbers to send to another process: few if the whole image was read, else with the histogram.
  std::vector<double> Pack() const;
  void Unpack(const std::vector<double>& numbers);

  /// The statistics of an array. They are cached for the last few arrays, as long as these do not change.
  static vtkSmartPointer<vtkChainMailScanStatistics> Of(vtkImageData* image, vtkDataArray* scalars);

  int GetKind() const;

  /// Whether a number is padding.
  bool IsPadding(double scalar) const;

  ///@{
  /// Padding is a number of at most GetLowPadding() or at least GetHighPadding(), which are infinite where there is
  /// none.
  double GetLowPadding() const;
  double GetHighPadding() const;
  ///@}

  /**
   * The value that air is shown as. For CT the median of air, for labels 0, else the median of the darkest peak. Where
   * there is no such peak it is the smallest scalar, without outliers (one in a thousand voxels).
   */
  double GetBackgroundValue() const;

  /**
   * The threshold and, if `function` is given, the function of a preset (vtkChainMailDeformation::MaterialPresets).
   * MATERIAL_FUNCTION is what fits the scan. For CT it is that of MATERIAL_CT. For labels 0 is air, and all else has
   * the constraint 0.2. For other scans air ends at a tenth of the way from GetBackgroundValue() to the brightest
   * voxels (without one in a thousand as outliers), and stiffness grows with the scalar without ever becoming rigid.
   */
  void GetMaterial(int preset, double& tissueThreshold, vtkPiecewiseFunction* function) const;

  /// A sentence about what the scan was taken for and why: "Taken for CT: 32 % of the voxels are near -1000 (air),
  /// ...".
  std::string GetDescription() const;

  /// One or two sentences about what makes the choice of a preset doubtful, and what to do; empty where nothing does.
  std::string GetDoubt(int preset) const;

protected:
  vtkChainMailScanStatistics();
  ~vtkChainMailScanStatistics() override;

private:
  vtkChainMailScanStatistics(const vtkChainMailScanStatistics&) = delete;
  void operator=(const vtkChainMailScanStatistics&) = delete;

  class vtkInternals;
  std::unique_ptr<vtkInternals> Internals;
};

#endif
