// SPDX-License-Identifier: BSD-3-Clause
// What the processes of a parallel server exchange in an update. The root process has the engine: it gets the inputs of
// all, computes alone, and hands each process the parts of the outputs that it was asked for. So the result cannot
// depend on the number of processes, nor on how the inputs are spread over them.

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

/// What all processes have to know about an update, apart from its images.
struct Outcome
{
  std::string Error; ///< for the user; empty where there is none
  bool Stopped = false;
  bool NeedsUpdate = false;
  bool Interacting = false;
};

class Exchange
{
public:
  /// With null this process works alone.
  explicit Exchange(vtkMultiProcessController* controller);

  bool IsRoot() const;

  /// Whether `mine` is true on all processes. All have to call this and the functions below, in the same order.
  bool All(bool mine) const;

  /// Brings the inputs of all processes to the root; the others get nothing. Data that several processes have alike
  /// count once. Parts of an image are put together where the root does not have all of it.
  Inputs Gather(const Inputs& mine) const;

  /// Sends the root's outcome to all.
  void Share(Outcome& outcome) const;

  /// Gives this process its `extent` of the root's image `whole`, with all field data.
  vtkSmartPointer<vtkImageData> Deliver(vtkImageData* whole, const std::array<int, 6>& extent) const;

  /// Gives every process all of an image of which each has a part, or the whole. `problem` is the same everywhere:
  /// empty, or why the parts do not fit together.
  vtkSmartPointer<vtkImageData> Assemble(
    vtkImageData* part, const std::array<int, 6>& whole, std::string& problem) const;

private:
  /// What one process has to send to the root.
  struct Wanted
  {
    std::vector<int> Numbers; ///< numbers of its leaves
    std::vector<Leaf> Leaves; ///< these leaves, still without data; known to the root alone
    bool Image = false;       ///< whether to send its part of the image

    void Write(vtkMultiProcessStream& stream) const;
    void Read(vtkMultiProcessStream& stream);
  };

  /// Chooses, among all that the processes say they have, what the root lacks. `problem`: the first one that a process
  /// has.
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
