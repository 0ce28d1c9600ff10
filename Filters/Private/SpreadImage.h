// SPDX-License-Identifier: BSD-3-Clause
// An image of which each process has a part, as the root reads it.

#ifndef SpreadImage_h
#define SpreadImage_h

#include "Exchange.h"
#include "Fingerprint.h"
#include "ImageParts.h"
#include "PartTissue.h"

#include "Model.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

class vtkChainMailScanStatistics;

namespace vtkChainMail
{

/// Reads the arrays of all parts, which are named by those of the root's own part. Reading is possible only while the
/// other processes serve (Team::Lead()); otherwise it throws std::logic_error.
class SpreadImage
{
public:
  SpreadImage(const Exchange& link, vtkImageData* own, const Holding& holding);
  ~SpreadImage();

  /// The geometry of the whole image, without arrays.
  vtkImageData* GetWhole() const { return this->Whole; }
  vtkImageData* GetOwn() const { return this->Own; }

  /// Reads rows when they are needed, and keeps some of them.
  chainmail::ArrayView View(vtkDataArray* ofOwn);
  /// The whole array, in the memory of this process.
  vtkSmartPointer<vtkDataArray> Gather(vtkDataArray* ofOwn) const;
  /// The smallest finite value of each component in all parts, see SmallestOf().
  vtkSmartPointer<vtkDataArray> GetSmallest(vtkAbstractArray* ofOwn);
  vtkSmartPointer<vtkChainMailScanStatistics> GetStatistics(vtkDataArray* ofOwn);
  /// The number of an array among the point arrays.
  int IndexOf(vtkAbstractArray* ofOwn) const;
  /// See chainmail::Material::count and chainmail::Material::reduce.
  chainmail::TissueCounts Count(const PartTissue& tissue) const;
  std::vector<chainmail::ReducedBox> Reduce(const PartTissue& tissue) const;
  /// Another one for other contents, or another image.
  Fingerprint FingerprintFor(vtkDataArray* ofOwn) const;

  /// While this exists, others serve.
  class Open
  {
  public:
    explicit Open(SpreadImage* image)
      : Image(image)
    {
      if (image)
      {
        image->IsOpen = true;
      }
    }
    ~Open()
    {
      if (this->Image)
      {
        this->Image->Close();
      }
    }
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;

  private:
    SpreadImage* Image;
  };

private:
  class Pages;

  /// Until the next Open: nothing can be read, and rows that were kept make room for other things.
  void Close();
  /// Gives other processes a task and does the own part of it, all at the same time. take(process, answer) follows.
  void Share(int command, const PartTissue& tissue, const std::vector<int>& others, const std::function<void()>& own,
    const std::function<void(int, const std::vector<char>&)>& take) const;
  /// Writes the values of a box of one array, x fastest.
  void Read(int array, const Extent& box, char* out) const;
  void RequireOpen() const;
  std::vector<char> Ask(int process, int command, int array, const Extent& box) const;

  Exchange Link;
  vtkSmartPointer<vtkImageData> Own;
  Holding Held;
  vtkSmartPointer<vtkImageData> Whole;
  Fingerprint Number;
  bool IsOpen = false;
  std::vector<std::weak_ptr<Pages>> Viewed;
  std::map<int, vtkSmartPointer<vtkChainMailScanStatistics>> Statistics;
  std::map<int, vtkSmartPointer<vtkDataArray>> Smallests;
};

}

#endif
