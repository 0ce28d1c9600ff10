// SPDX-License-Identifier: BSD-3-Clause
// Reports the progress of an update to the user, and the durations of its parts.

#ifndef Progress_h
#define Progress_h

#include "Error.h"

#include "vtkAlgorithm.h"
#include "vtkVersionMacros.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>

namespace vtkChainMail
{

/// The components of the field array Milliseconds.
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
    this->Running.reset();
    this->Shown = 0.0;
  }

  /// Runs a part of the update. Its duration is added to component `time` of Milliseconds, and the engine's progress
  /// within it is mapped to [from, to].
  template <typename F> void Run(Times time, double from, double to, F&& part)
  {
    if (!this->BeginPart(time, from, to))
    {
      throw chainmail::Aborted();
    }
    part();
    this->EndPart();
  }

  /// Begins a part as Run() does, after the end of the one before. Returns false where somebody has asked to stop.
  bool BeginPart(Times time, double from, double to)
  {
    this->EndPart();
    // Texts for the progress bar.
    static const char* const names[NUMBER_OF_TIMES] = { "ChainMail: reading the tissue", "ChainMail: pulling",
      "ChainMail: settling", "ChainMail: moving the voxels", "ChainMail: reading back" };
    this->Part = names[time];
    this->Tell(this->Part);
    this->From = from;
    this->To = to;
    const bool goesOn = this->Show(0.0);
    this->Running = time;
    this->Start = std::chrono::steady_clock::now();
    return goesOn;
  }

  /// Ends the present part, if there is one.
  void EndPart()
  {
    if (this->Running)
    {
      const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - this->Start;
      this->Milliseconds[*this->Running] += elapsed.count();
      this->Running.reset();
    }
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
    // A part may call the engine several times, each counting from 0. The progress shown never decreases.
    this->Shown = std::max(this->Shown, this->From + share * (this->To - this->From));
    return this->Send();
  }

  /// Sends a progress event with the text that kernels are compiled. Returns false where somebody has asked to stop.
  bool ShowCompiling()
  {
    if (!this->IsCompiling)
    {
      this->IsCompiling = true;
      this->Tell("Compiling kernels");
    }
    return this->Send();
  }

  /// To be called when an update ends, with or without an error: restores the filter's own progress text.
  void End()
  {
    if (this->IsTelling)
    {
      this->Filter->SetProgressText(this->TextBefore.empty() ? nullptr : this->TextBefore.c_str());
    }
    this->IsTelling = false;
    this->IsCompiling = false;
    this->Running.reset();
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
  std::optional<Times> Running; ///< the component of the present part
  std::chrono::steady_clock::time_point Start;
  double From = 0.0;
  double To = 1.0;
  double Shown = 0.0;
  const char* Part = nullptr; ///< text of the current part
  bool IsCompiling = false;
  bool IsTelling = false;
  std::string TextBefore;
};

}

#endif
