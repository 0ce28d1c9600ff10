// SPDX-License-Identifier: BSD-3-Clause
// What the processes of a parallel server exchange in an update. The root process has the simulation, and gets the
// probes and surfaces of all processes. The image stays where it is. Each process makes its own part of the outputs,
// for which the root sends it tissue. So the result depends neither on the number of processes nor on how the inputs
// are distributed over them.

#ifndef Exchange_h
#define Exchange_h

#include "ImageParts.h"
#include "Inputs.h"

#include <array>
#include <string>
#include <vector>

class vtkDataArray;
class vtkDataObject;
class vtkFieldData;
class vtkMultiProcessController;
class vtkMultiProcessStream;
class vtkPolyData;

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
  static constexpr int Root = 0;

  /// Null: this process works alone.
  explicit Exchange(vtkMultiProcessController* controller);

  bool IsRoot() const;

  /// Whether `mine` is true on all processes. All processes have to call this and the functions below, in the same
  /// order.
  bool All(bool mine) const;

  /// Sends the inputs of all processes to the root; the others get nothing. Equal data of several processes count once.
  /// Where the root does not have all of the image, and each process has a piece of it as VTK divides images, the image
  /// stays spread, as `holding` says then on all processes, and the root has its own part. Otherwise it is assembled.
  /// Where only the root has an image, and VTK frees that after the update, `mine` gets a piece of it on all processes,
  /// and it is spread, too. `isKnown`: the same on all processes; the image and `holding` are as in the last call, and
  /// `known` is the root's image.
  Inputs Gather(Inputs& mine, bool isKnown, vtkImageData* known, Holding& holding) const;

  /// Gives all processes the same outcome: the first process's error or stop, and what the root says of the state.
  void Agree(Outcome& outcome) const;

  int GetSize() const;
  int GetRank() const;
  /// The numbers of all processes one after the other, on the root. Each gives equally many.
  std::vector<int> ToRoot(const std::vector<int>& mine) const;
  std::vector<vtkTypeInt64> ToRoot(const std::vector<vtkTypeInt64>& mine) const;
  /// The same on all processes.
  std::vector<int> ToAll(const std::vector<int>& mine) const;
  /// Gives all processes what the root has.
  void FromRoot(vtkMultiProcessStream& stream) const;
  vtkTypeUInt64 FromRoot(vtkTypeUInt64 number) const;
  std::vector<vtkSmartPointer<vtkDataArray>> FromRoot(std::vector<vtkSmartPointer<vtkDataArray>> arrays) const;
  void FromRoot(vtkFieldData* fields) const;

  // What the root asks of another process (Team): a command, an array, the extent of a box. A message with more follows
  // COUNT and REDUCE.
  enum Commands
  {
    END,
    OFFER,
    VALUES,
    COUNT,
    STATISTICS,
    SMALLEST,
    REDUCE
  };
  using Command = std::array<int, 8>;
  void Request(int process, const Command& command) const;
  Command ReceiveRequest() const;
  void EndRequests() const;

  // From one process to another one, which receives it at the same time. Where the receiver has not enough memory, it
  // receives to the end and then throws std::bad_alloc.
  void Send(const std::vector<char>& bytes, int to) const;
  std::vector<char> Receive(int from) const;
  /// Sends only what is not 0, into memory that is 0. Pages that stay 0 are not written, so the system need not provide
  /// them. Null: the receiver has no memory, and gets nothing.
  void SendSparse(const char* values, std::size_t bytes, int to) const;
  void ReceiveSparse(char* zeros, int from) const;
  void Send(vtkImageData* image, int to) const;
  vtkSmartPointer<vtkImageData> ReceiveImage(int from) const;

  /// Gives this process its `extent` of the root's image `whole`, with all field data; nothing of it where the root has
  /// not enough memory.
  vtkSmartPointer<vtkImageData> Deliver(vtkImageData* whole, const std::array<int, 6>& extent) const;

  /// Gives every process the whole of an image of which each process has a part or the whole. `problem` is the same on
  /// all processes: empty, or why the parts do not fit together.
  vtkSmartPointer<vtkImageData> Assemble(
    vtkImageData* part, const std::array<int, 6>& whole, std::string& problem) const;

private:
  // A block of memory, in messages of some MB.
  void SendBlock(const char* memory, std::size_t bytes, int to) const;
  /// `memory`: null where there is none; what comes is dropped then.
  void ReceiveBlock(char* memory, std::size_t bytes, int from) const;
  void Send(vtkPolyData* data, int to) const;
  vtkSmartPointer<vtkPolyData> ReceiveSurface(int from) const;

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
  static std::vector<Wanted> Choose(const Inputs& mine, bool isKnown, std::vector<vtkMultiProcessStream>& abouts,
    std::string& problem, Holding& holding);
  /// Replaces the image of each process by its piece of the root's image, as VTK divides images.
  void Divide(Inputs& mine, std::string& problem) const;
  void Send(const Inputs& mine, const Wanted& wanted) const;
  void Receive(const Inputs& mine, const std::vector<Wanted>& wanted, Inputs& all) const;

  vtkMultiProcessController* Controller;
};

}

#endif
