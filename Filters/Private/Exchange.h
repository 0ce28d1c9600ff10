// SPDX-License-Identifier: BSD-3-Clause
// What the processes of a parallel server exchange in an update. The root process has the engine: it gets the inputs of
// all processes, computes alone, and sends each process its requested parts of the outputs. So the result depends
// neither on the number of processes nor on how the inputs are distributed over them.

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

/// The result of an update that all processes need, apart from its images.
struct Outcome
{
  std::string Error; ///< message for the user; empty where there is no error
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

  /// Whether `mine` is true on all processes. All processes have to call this and the functions below, in the same
  /// order.
  bool All(bool mine) const;

  /// Sends the inputs of all processes to the root; the others get nothing. Equal data of several processes count once.
  /// The image is assembled from its parts where the root does not have all of it.
  Inputs Gather(const Inputs& mine) const;

  /// Sends the root's outcome to all.
  void Share(Outcome& outcome) const;

  /// Gives this process its `extent` of the root's image `whole`, with all field data.
  vtkSmartPointer<vtkImageData> Deliver(vtkImageData* whole, const std::array<int, 6>& extent) const;

  /// Gives every process the whole of an image of which each process has a part or the whole. `problem` is the same on
  /// all processes: empty, or why the parts do not fit together.
  vtkSmartPointer<vtkImageData> Assemble(
    vtkImageData* part, const std::array<int, 6>& whole, std::string& problem) const;

private:
  /// What one process has to send to the root.
  struct Wanted
  {
    std::vector<int> Numbers;         ///< numbers of its leaves
    std::vector<InputDataset> Leaves; ///< these leaves without their data; set on the root only
    bool Image = false;               ///< whether to send its part of the image

    void Write(vtkMultiProcessStream& stream) const;
    void Read(vtkMultiProcessStream& stream);
  };

  /// Chooses from the lists of all processes what the root lacks. `problem` is that of the first process with one.
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
