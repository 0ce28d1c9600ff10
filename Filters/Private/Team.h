// SPDX-License-Identifier: BSD-3-Clause
// The processes that update a filter together, and how the input image is spread over them.

#ifndef Team_h
#define Team_h

#include "Exchange.h"
#include "ImageParts.h"
#include "SpreadImage.h"
#include "Steps.h"

#include "vtkImageData.h"
#include "vtkSmartPointer.h"

#include <functional>
#include <memory>

namespace vtkChainMail
{

/// The root leads: the other processes answer its requests and take what it sends them.
class Team
{
public:
  /// `own`: the part of the image that this process has; may be null. `spread`: on the root, where the image is spread.
  Team(const Exchange& link, vtkImageData* own, const Holding& holding, std::shared_ptr<SpreadImage> spread)
    : Link(link)
    , Own(own)
    , Held(holding)
    , Spread(std::move(spread))
  {
  }

  const Exchange& GetLink() const { return this->Link; }
  bool IsSpread() const { return this->Held.IsSpread(); }
  vtkImageData* GetOwn() const { return this->Own; }

  /// Takes what the root sends after Offer().
  using Take = std::function<void(int what, int where)>;

  /// Runs a step of the root, which may read voxels of all processes, and offer them something. Meanwhile the others
  /// serve it. All processes call this together.
  template <typename F> void Lead(Steps& steps, F&& step, const Take& take = nullptr) const
  {
    if (this->Link.IsRoot())
    {
      steps.Run(
        [&]
        {
          const SpreadImage::Open open(this->Spread.get());
          step();
        });
      this->Link.EndRequests();
    }
    else
    {
      this->Serve(take);
    }
  }
  /// On the root, within a step: a process is to take what is sent to it next.
  void Offer(int process, int what, int where = 0) const
  {
    this->Link.Request(process, { { Exchange::OFFER, what, where } });
  }

  /// The part of the image with this extent, which may be empty. Voxels within `known`, a part of GetOwn(), are left
  /// out. All processes call this together, where the image is spread; what it throws, it throws after the last
  /// exchange.
  vtkSmartPointer<vtkImageData> Fetch(const Extent& wanted, const Extent& known = { { 0, -1, 0, -1, 0, -1 } }) const;

private:
  void Serve(const Take& take) const;
  void RequireOwn() const;
  vtkSmartPointer<vtkImageData> Give(const Extent& box) const;

  Exchange Link;
  vtkSmartPointer<vtkImageData> Own;
  Holding Held;
  std::shared_ptr<SpreadImage> Spread;
};

}

#endif
