// SPDX-License-Identifier: BSD-3-Clause
// Bones that touch: one body without labels, several with BodyArray or JointSize; what the outputs and the report say
// of them; and that labels come along: in pieces, edited in place, in Interactive mode.

#include "FilterTest.h"

#include "vtkDataArraySelection.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkTypeInt64Array.h"
#include "vtkTypeUInt64Array.h"
#include "vtkUnsignedShortArray.h"

#include <set>
#include <utility>

using namespace FilterTest;

namespace
{

/// A finger of five bones with skin around them, along x. The first bone touches the face x- and goes on beyond it;
/// each touches the next one with 3 x 3 voxels.
struct Finger
{
  vtkSmartPointer<vtkImageData> Image = MakeImage({ { 0, 62, 0, 16, 0, 16 } });
  vtkSmartPointer<vtkUnsignedShortArray> Labels = vtkSmartPointer<vtkUnsignedShortArray>::New();

  Finger()
  {
    Fill(this->Image->GetPointData()->GetScalars(), this->Image,
      [](int i, int j, int k) { return Finger::Bone(i, j, k) > 0 ? 1200 : 50; });
    this->Labels->SetName("Bones");
    this->Labels->SetNumberOfTuples(this->Image->GetNumberOfPoints());
    Fill(this->Labels, this->Image, [](int i, int j, int k) { return 10 * Finger::Bone(i, j, k); });
    this->Image->GetPointData()->AddArray(this->Labels);
  }

  static int Bone(int i, int j, int k)
  {
    const int n = i / 12;
    const int reach = i % 12 < 11 ? 4 : 1;
    const bool isBone = n < (i % 12 < 11 ? 5 : 4) && std::abs(j - 8) <= reach && std::abs(k - 8) <= reach;
    return isBone ? n + 1 : 0;
  }

  void Connect(vtkChainMailDeformation* filter)
  {
    filter->SetInputData(this->Image);
    filter->SetMaterialPresetToCT();
    filter->SetAnchoredFaces(1, 0, 0, 0, 0, 0);
    filter->GetModelArraySelection()->EnableAllArrays();
  }
};

vtkSmartPointer<vtkPolyData> PullTip(double far)
{
  return MakeProbes({ { { { 58, 8, 8 } }, { { 0, 0, far } } } });
}

/// How many clusters the model has.
std::size_t CountClusters(vtkChainMailDeformation* filter)
{
  vtkDataArray* numbers = filter->GetModelOutput()->GetPointData()->GetArray("Cluster");
  std::set<double> found;
  for (vtkIdType v = 0; v < numbers->GetNumberOfTuples(); ++v)
  {
    found.insert(numbers->GetTuple1(v));
  }
  return found.size() - found.count(-1.0);
}

}

int TestChainMailBodies(int, char*[])
{
  Checks check;
  Finger finger;
  vtkNew<vtkChainMailDeformation> filter;
  EventLog log{ filter };
  finger.Connect(filter);
  filter->SetInputDataObject(1, PullTip(1.0));
  const auto update = [&](const std::string& where)
  {
    filter->Update();
    check.Equal(log.TakeErrors(), std::string(), where);
    return Field(filter->GetOutput(), "ProbeReached", 2);
  };

  check.Equal(update("no bodies"), 0.0, "what touches a face holds the tip");
  check.That(!filter->GetOutput()->GetFieldData()->HasArray("BodyVoxels"), "nothing is said of bodies");
  check.That(std::string(filter->GetReport()).find("bodies") == std::string::npos, "nor in the report");
  check.Equal(CountClusters(filter), std::size_t(1), "one cluster");

  for (const bool labels : { true, false })
  {
    const std::string where = labels ? "BodyArray: " : "JointSize: ";
    filter->SetBodyArray(labels ? "Bones" : "");
    filter->SetJointSize(labels ? 0 : 4);
    check.Near(update(where), 1.0, 1e-6, where + "the tip goes where it is pulled");
    check.Equal(CountClusters(filter), std::size_t(5), where + "five clusters");
    vtkFieldData* fields = filter->GetOutput()->GetFieldData();
    check.Equal(fields->GetArray("BodyVoxels")->GetNumberOfTuples(), vtkIdType(5), where + "a row for each");
    // Of 891 voxels and the bridge of 9 to the next bone, the larger bone or, of equal ones, the later one gives way.
    const double voxels[] = { 900, 891, 891, 882, 891 };
    for (int n = 0; n < 5; ++n)
    {
      check.Equal(
        Field(filter->GetOutput(), "BodyVoxels", 0, n), voxels[n], where + "voxels of bone " + std::to_string(n));
      check.Equal(Field(filter->GetModelOutput(), "BodyHeldBy", 0, n),
        n == 0   ? 1.0
        : n == 4 ? 3.0
                 : 0.0,
        where + "holder of bone " + std::to_string(n));
      if (labels)
      {
        check.Equal(Field(filter->GetOutput(), "BodyLabel", 0, n), 10.0 * (n + 1), where + "label");
      }
    }
    const std::string report = filter->GetReport();
    check.Contains(report, "5 bodies of bone, 2 held: ", where);
    check.Contains(
      report, labels ? "label 10 (900 voxels) by the face x- of the scan" : "body 0 (900 voxels) by the face", where);
    check.Contains(report, labels ? "label 50 (891 voxels) by Probe 1" : "body 4 (891 voxels) by Probe 1", where);
    check.That(report.find("limit") == std::string::npos, where + "no joint is at its limit");

    // Too far for the joints, all of which are on the way to the face; free ones are where their sleeves are tight.
    filter->SetInputDataObject(1, PullTip(100.0));
    for (const double constraint : { 0.5, 1.0 })
    {
      filter->SetJointConstraint(constraint);
      update(where + "too far");
      check.Contains(filter->GetReport(),
        labels
          ? "; the joints of label 50 and label 40, of label 40 and label 30, of label 30 and label 20, of label 20 "
            "and label 10 are at their limits.\n"
          : " are at their limits.\n",
        where + "joints, constraint " + std::to_string(constraint));
      check.Equal(std::string(filter->GetReport()).find("; the joints of the bone at (") != std::string::npos, !labels,
        where + "bodies without labels by their places");
    }
    filter->SetJointConstraint(0.5);
    filter->SetInputDataObject(1, PullTip(1.0));
  }

  // Labels to the last digit.
  {
    const vtkTypeInt64 huge = (vtkTypeInt64(1) << 60) + 1;
    vtkNew<vtkTypeInt64Array> labels;
    labels->SetName("Huge");
    labels->SetNumberOfTuples(finger.Image->GetNumberOfPoints());
    for (vtkIdType v = 0; v < labels->GetNumberOfTuples(); ++v)
    {
      const auto bone = static_cast<vtkTypeInt64>(finger.Labels->GetValue(v) / 10);
      labels->SetValue(v, bone > 0 ? huge + bone : 0);
    }
    finger.Image->GetPointData()->AddArray(labels);
    filter->SetBodyArray("Huge");
    filter->SetJointSize(0);
    update("huge labels");
    auto* names = vtkIdTypeArray::SafeDownCast(filter->GetOutput()->GetFieldData()->GetArray("BodyLabel"));
    for (int n = 0; names && n < 5; ++n)
    {
      check.That(names->GetValue(n) == huge + n + 1, "a huge label");
    }
    check.Contains(
      filter->GetReport(), "label " + std::to_string(huge + 1) + " (900 voxels)", "a huge label in the report");

    // What is no label is said in numbers that one can read.
    vtkNew<vtkDoubleArray> odd;
    odd->SetName("Odd");
    odd->DeepCopy(finger.Labels);
    odd->SetName("Odd");
    finger.Image->GetPointData()->AddArray(odd);
    const vtkIdType inBone = finger.Image->vtkDataSet::FindPoint(6.0, 8.0, 8.0);
    filter->SetBodyArray("Odd");
    const std::pair<double, const char*> cases[] = { { 6.5, " is 6.5; labels have to be whole" },
      { 1e300, " is 1e+300; labels have to be whole numbers up to 9e+18" }, { -0.1, " is -0.1; " } };
    for (const auto& [value, text] : cases)
    {
      odd->SetValue(inBone, value);
      odd->Modified();
      finger.Image->Modified();
      filter->Update();
      check.Contains(log.TakeErrors(), text, "what is no label");
    }
    finger.Image->GetPointData()->RemoveArray("Odd");
    vtkNew<vtkTypeUInt64Array> beyond;
    beyond->DeepCopy(labels);
    beyond->SetName("Beyond");
    beyond->SetValue(inBone, ~vtkTypeUInt64(0));
    finger.Image->GetPointData()->AddArray(beyond);
    filter->SetBodyArray("Beyond");
    filter->Update();
    check.Contains(log.TakeErrors(), "18446744073709551615; labels have to be", "a label beyond all");
    finger.Image->GetPointData()->RemoveArray("Beyond");
    finger.Image->GetPointData()->RemoveArray("Huge");
  }

  // The labels themselves are deformed as labels.
  filter->SetBodyArray("Bones");
  filter->SetJointSize(0);
  filter->SetInputDataObject(1, PullTip(1.5));
  update("labels");
  std::set<double> values;
  vtkDataArray* sampled = filter->GetOutput()->GetPointData()->GetArray("Bones");
  for (vtkIdType v = 0; v < sampled->GetNumberOfTuples(); ++v)
  {
    values.insert(sampled->GetTuple1(v));
  }
  check.That(values == std::set<double>({ 0, 10, 20, 30, 40, 50 }), "no mixture of labels");

  // Written to in place: the last two bones become one.
  Fill(finger.Labels, finger.Image, [](int i, int j, int k) { return 10 * std::min(4, Finger::Bone(i, j, k)); });
  finger.Labels->Modified();
  update("edited");
  check.Equal(CountClusters(filter), std::size_t(4), "edited labels");
  // The same contents in another array go on from where they were, step by step.
  filter->SetModeToInteractive();
  filter->SetRelaxationIterations(1);
  update("step by step");
  auto copy = vtkSmartPointer<vtkUnsignedShortArray>::New();
  copy->DeepCopy(finger.Labels);
  finger.Image->GetPointData()->AddArray(copy);
  finger.Image->Modified();
  update("copied");
  check.Equal(Field(filter->GetOutput(), "Milliseconds", UPLOAD), 0.0, "equal labels are the same tissue");
  copy->SetValue(copy->GetNumberOfTuples() / 2, 77);
  copy->Modified();
  update("edited while the tip is held");
  check.That(Field(filter->GetOutput(), "Milliseconds", UPLOAD) > 0.0, "other labels are other tissue");
  filter->SetModeToFromRest();

  // A piece of the output is that piece of the whole.
  filter->SetRelaxationIterations(20);
  update("whole");
  vtkNew<vtkImageData> whole;
  whole->DeepCopy(filter->GetOutput());
  int extent[6] = { 20, 45, 3, 12, 0, 16 };
  filter->Modified();
  filter->UpdateExtent(extent);
  check.Equal(log.TakeErrors(), std::string(), "a piece");
  vtkNew<vtkImageData> part;
  part->ShallowCopy(filter->GetOutput());
  whole->Crop(part->GetExtent());
  check.That(SameImage(part, whole), "a piece is the same");

  // What is refused says so, and the next update goes on.
  filter->SetModelReduction(2);
  filter->Update();
  check.Contains(log.TakeErrors(), "closes the joints", "a reduced model");
  filter->SetModelReduction(1);
  update("after the error");
  return check.Finish();
}
