// SPDX-License-Identifier: BSD-3-Clause
// Tells the user how an update goes on while it runs, and how long its parts took.

#ifndef Progress_h
#define Progress_h

#include "Error.h"

#include "vtkAlgorithm.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

namespace vtkChainMail
{

/// The rows of the field array Milliseconds.
enum Times
{
  UPLOAD,
  PROPAGATE,
  RELAX,
  RESAMPLE,
  DOWNLOAD,
  NUMBER_OF_TIMES
};

/// Progress events, requests to stop, warnings and times of one filter's updates.
class Progress
{
public:
  explicit Progress(vtkAlgorithm* filter)
    : Filter(filter)
  {
  }

  /// To be called when an update begins.
  void Begin()
  {
    this->Milliseconds.fill(0.0);
    this->Shown = 0.0;
  }

  /// Runs a part of the update. Its time is added to a row of Milliseconds, and the engine's progress in it is mapped
  /// to [from, to].
  template <typename F> void Run(Times time, double from, double to, F&& part)
  {
    // What a progress bar shows beside the number.
    static const char* const names[NUMBER_OF_TIMES] = { "ChainMail: reading the tissue", "ChainMail: pulling",
      "ChainMail: settling", "ChainMail: moving the voxels", "ChainMail: reading back" };
    this->Part = names[time];
    this->Tell(this->Part);
    this->From = from;
    this->To = to;
    this->Report(0.0);
    const auto start = std::chrono::steady_clock::now();
    part();
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    this->Milliseconds[time] += elapsed.count();
  }

  /// Sends a progress event. Throws Aborted where somebody has asked to stop.
  void Report(double share)
  {
    if (!this->Show(share))
    {
      throw chainmail::Aborted();
    }
  }

  /// Sends a progress event. Returns false where somebody has asked to stop.
  bool Show(double share)
  {
    if (this->IsCompiling)
    {
      this->IsCompiling = false;
      this->Tell(this->Part);
    }
    // Where a part calls the engine several times, each call counts from 0; the progress shown never goes back.
    this->Shown = std::max(this->Shown, this->From + share * (this->To - this->From));
    return this->Send();
  }

  /// Sends a progress event that says what takes so long. Returns false where somebody has asked to stop.
  bool ShowCompiling()
  {
    if (!this->IsCompiling)
    {
      this->IsCompiling = true;
      this->Tell("Compiling kernels");
    }
    return this->Send();
  }

  /// To be called when an update ends, however it does: gives the filter its own progress text back.
  void End()
  {
    if (this->IsTelling)
    {
      this->Filter->SetProgressText(this->TextBefore.empty() ? nullptr : this->TextBefore.c_str());
    }
    this->IsTelling = false;
    this->IsCompiling = false;
  }

  /// Sends a warning; none where the text is empty.
  void Warn(const std::string& text)
  {
    if (!text.empty())
    {
      vtkWarningWithObjectMacro(this->Filter, << text);
    }
  }

  const std::array<double, NUMBER_OF_TIMES>& GetMilliseconds() const { return this->Milliseconds; }

private:
  void Tell(const char* text)
  {
    if (!this->IsTelling)
    {
      const char* before = this->Filter->GetProgressText();
      this->TextBefore = before ? before : "";
      this->IsTelling = true;
    }
    this->Filter->SetProgressText(text);
  }

  bool Send()
  {
    this->Filter->UpdateProgress(this->Shown);
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 20220823)
    return !this->Filter->CheckAbort();
#else
    return !this->Filter->GetAbortExecute();
#endif
  }

  vtkAlgorithm* Filter;
  std::array<double, NUMBER_OF_TIMES> Milliseconds{};
  double From = 0.0;
  double To = 1.0;
  double Shown = 0.0;
  const char* Part = nullptr; ///< what is under way
  bool IsCompiling = false;
  bool IsTelling = false;
  std::string TextBefore;
};

}

#endif
