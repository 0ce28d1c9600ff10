// SPDX-License-Identifier: BSD-3-Clause
// What the processes of a parallel server tell each other in an update. The root process has the engine: it is given
// the inputs of all, computes alone, and hands each one the parts of the outputs that it was asked for. So the result
// cannot depend on how many there are, nor on how the inputs are spread over them.

#ifndef Exchange_h
#define Exchange_h

#include "Inputs.h"

#include <array>
#include <string>
#include <vector>

class vtkDataObject;
class vtkMultiProcessController;
class vtkMultiProcessStream;

namespace vtkChainMail
{

/// What all processes have to know of an update, apart from its images.
struct Outcome
{
  std::string Error; ///< for the user; empty: none
  bool Stopped = false;
  bool NeedsUpdate = false;
  bool Interacting = false;
};

class Exchange
{
public:
  /// Null: this process works alone.
  explicit Exchange(vtkMultiProcessController* controller);

  bool IsRoot() const;

  /// Whether `mine` holds on all processes.
  bool All(bool mine) const;

  /// Brings what the processes have to the root; to the others nothing. What several have alike counts once. Parts of
  /// an image are put together where the root does not have all of it.
  Inputs Gather(const Inputs& mine) const;

  /// From the root to all.
  void Share(Outcome& outcome) const;

  /// Cuts `extent` of this process out of the root's `whole`, with all field data.
  vtkSmartPointer<vtkImageData> Deliver(vtkImageData* whole, const std::array<int, 6>& extent) const;

private:
  /// What one process is to send to the root.
  struct Wanted
  {
    std::vector<int> Numbers; ///< of its leaves
    std::vector<Leaf> Leaves; ///< these, still without data; known to the root alone
    bool Image = false;       ///< its part of it

    void Write(vtkMultiProcessStream& stream) const;
    void Read(vtkMultiProcessStream& stream);
  };

  /// Of all that the processes say they have what the root lacks. `problem`: the first that one of them has.
  static std::vector<Wanted> Choose(
    const Inputs& mine, std::vector<vtkMultiProcessStream>& abouts, std::string& problem);
  void Send(const Inputs& mine, const Wanted& wanted) const;
  void Receive(const Inputs& mine, const std::vector<Wanted>& wanted, Inputs& all) const;

  void Send(vtkImageData* image, int to) const;
  vtkSmartPointer<vtkImageData> Receive(int from) const;

  vtkMultiProcessController* Controller;
};

}

#endif
