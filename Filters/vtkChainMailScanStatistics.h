// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkChainMailScanStatistics
 * @brief   tells what the scalars of a scan are: Hounsfield units, labels, or numbers without a unit
 *
 * All that vtkChainMailDeformation and the plugin guess about a scan comes from here: which material fits it, where air
 * ends, what air is shown as, and which voxels are padding. It counts the scalars and looks at where most of them are,
 * so a few voxels that are wrong, or rings beside edges, change nothing. The rules, of which the first that applies
 * counts:
 *
 * - **Padding** is a number that stands for "nothing was measured here". It is set aside, and is neither air nor
 * tissue. Below: one of the numbers in use (-32768, -9999, -4096, -3072, -3024, -3000, -2048, -2000), or any below
 * -1200 in a scan that is CT without it, of which there are more voxels than of anything else within 200 of it. Above:
 * 32767, 32768 and the last 4096 numbers of 16 bits, as -2000 is 63536 where the sign is lost, if all else is below
 * 16384.
 * - KIND_LABELS: whole numbers from 0 up in an array of integers, at least two labels and at most 4096; of neighbours
 *   along a row that are not both 0 most are equal; and labels meet that are not next to each other in number, as grey
 *   values of a smooth picture are. A few numbers with wide gaps, and two numbers alone (a mask), are not taken for
 * labels.
 * - KIND_CT: of the voxels at least one in a thousand is air or lung (-1100 to -600), more of them for each unit than
 *   between -500 and -250, where rings would be, or in a peak at air; hardly any are below; and of all from -300 up a
 * tenth lies between -200 and 200, as fat, water, muscle and organs do. Or, in a crop without air, nearly all lies
 * there, with fat and muscle in their places and next to nothing below fat.
 * - KIND_UNKNOWN: all else, such as MR, or CT that was stretched or stored in 8 bits.
 *
 * Where the image has more than 2^24 voxels it reads every n-th row, so its time is bounded: some hundredths of a
 * second. Of an image in pieces (see Merge()) it finds the same as of the whole, whatever the type of the array.
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

  /// Reads a part of an image that has the extent `whole` in all. Voxels that several parts share count once.
  void ReadPart(vtkImageData* part, vtkDataArray* scalars, const int whole[6]);

  /// Adds what `other` has read, another part of the same image. Where one of the two has all of it, that one counts.
  void Merge(vtkChainMailScanStatistics* other);

  /// What was read, in numbers for another process: few where all of the image was read.
  std::vector<double> Pack() const;
  void Unpack(const std::vector<double>& numbers);

  /// The statistics of an array, which are kept for the last few arrays as long as these stay as they are.
  static vtkSmartPointer<vtkChainMailScanStatistics> Of(vtkImageData* image, vtkDataArray* scalars);

  int GetKind() const;

  /// Whether a number is padding.
  bool IsPadding(double scalar) const;

  ///@{
  /// Padding is what is at most GetLowPadding() or at least GetHighPadding(); infinite where there is none.
  double GetLowPadding() const;
  double GetHighPadding() const;
  ///@}

  /**
   * What air is shown as: the median of air in CT, 0 of labels, else the median of the darkest peak or, where there is
   * none, the darkest of the voxels, without the one in a thousand that is far from the others.
   */
  double GetBackgroundValue() const;

  /**
   * The threshold and, if `function` is given, the function of a preset (vtkChainMailDeformation::MaterialPresets).
   * MATERIAL_FUNCTION is what fits: the CT's material; of labels 0 is air, and all else has the constraint 0.2; of
   * other scans air ends at a tenth of the way from GetBackgroundValue() to the brightest voxels, of which one in a
   * thousand is left out, and stiffness grows with the scalar without ever becoming rigid.
   */
  void GetMaterial(int preset, double& tissueThreshold, vtkPiecewiseFunction* function) const;

  /// What the scan was taken for and why, as a sentence: "Taken for CT: 32 % of the voxels are near -1000 (air), ...".
  std::string GetDescription() const;

  /// What makes the choice of a preset doubtful, and what to do, in one or two sentences; empty where nothing does.
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
