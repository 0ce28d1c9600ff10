// SPDX-License-Identifier: BSD-3-Clause
#include "pqChainMailPoseWidget.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqDoubleLineEdit.h"
#include "pqPipelineSource.h"
#include "pqServerManagerModel.h"

#include "vtk3DWidgetRepresentation.h"
#include "vtkActor.h"
#include "vtkBoundingBox.h"
#include "vtkBoxRepresentation.h"
#include "vtkCommand.h"
#include "vtkMath.h"
#include "vtkPVDataInformation.h"
#include "vtkPropCollection.h"
#include "vtkSMNewWidgetRepresentationProxy.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyGroup.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <QCheckBox>
#include <QGridLayout>
#include <QIntValidator>
#include <QLabel>

#include <algorithm>
#include <cmath>
#include <vector>

namespace
{
// Half the box where there is no bone, as a share of the scan's diagonal, and in mm where there is no scan either.
constexpr double EmptyShare = 0.05;
constexpr double EmptyHalf = 10.0;
}

//------------------------------------------------------------------------------
pqChainMailPoseWidget::pqChainMailPoseWidget(vtkSMProxy* proxy, vtkSMPropertyGroup* group, QWidget* parent)
  : Superclass("representations", "BoxWidgetRepresentation", proxy, group, parent)
{
  auto* grid = new QGridLayout(this);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setSpacing(2);
  auto* shown = new QCheckBox(tr("Show Box"), this);
  shown->setObjectName("show3DWidget");
  shown->setChecked(true);
  grid->addWidget(shown, 0, 0, 1, 4);
  int row = 1;
  for (const char* function : { "Centre", "Position", "Rotation", "Body" })
  {
    vtkSMProperty* property = group->GetProperty(function);
    const QString help = this->getTooltip(property);
    auto* label = new QLabel(property->GetXMLLabel(), this);
    label->setToolTip(help);
    grid->addWidget(label, row, 0);
    const int count = static_cast<int>(vtkSMPropertyHelper(property).GetNumberOfElements());
    for (int n = 0; n < count; ++n)
    {
      pqLineEdit* edit = count == 3 ? new pqDoubleLineEdit(this) : new pqLineEdit(this);
      edit->setObjectName(count == 3 ? QString(function) + "XYZ"[n] : QString(function));
      edit->setToolTip(help);
      if (count == 1)
      {
        edit->setValidator(new QIntValidator(-1, VTK_INT_MAX, edit));
      }
      grid->addWidget(edit, row, n + 1);
      this->addPropertyLink(edit, "text2", SIGNAL(textChangedAndEditingFinished()), property, n);
    }
    ++row;
  }
  // Where the box is depends on these two; it is linked to the others.
  for (const char* function : { "Centre", "Body" })
  {
    for (const auto event : { vtkCommand::UncheckedPropertyModifiedEvent, vtkCommand::ModifiedEvent })
    {
      pqCoreUtilities::connect(group->GetProperty(function), event, this, SLOT(placeWidget()));
    }
  }
  auto* help =
    new QLabel(tr("In the view, drag a face of the box to turn the bone, and the ball in its middle to move it. "
                  "With the mouse over another bone, the key P holds that bone."),
      this);
  help->setObjectName("pickLabel");
  help->setWordWrap(true);
  grid->addWidget(help, row, 0, 1, 4);
  this->setChangeAvailableAsChangeFinished(true);

  vtkSMProxy* box = this->widgetProxy();
  for (const char* name : { "ScalingEnabled", "MoveFacesEnabled", "UseReferenceBounds" })
  {
    vtkSMPropertyHelper(box, name).Set(0);
  }
  box->UpdateVTKObjects();
  if (auto* drawn = vtk3DWidgetRepresentation::SafeDownCast(box->GetClientSideObject()))
  {
    drawn->UseNonCompositedRendererOn(); // as ParaView's lines are, over the tissue that hides the bone
  }
  this->hideHandles();

  this->connect(shown, SIGNAL(toggled(bool)), SLOT(setWidgetVisible(bool)));
  shown->connect(this, SIGNAL(widgetVisibilityToggled(bool)), SLOT(setChecked(bool)));
  this->setWidgetVisible(true);
  QObject::connect(this, &pqInteractivePropertyWidget::widgetVisibilityUpdated, this,
    [this](bool visible)
    {
      if (visible)
      {
        this->placeWidget();
      }
    });
  // It becomes the probe of a deformation, or that has other bones now.
  QObject::connect(pqApplicationCore::instance()->getServerManagerModel(), &pqServerManagerModel::dataUpdated, this,
    [this](pqPipelineSource* updated)
    {
      if (!this->IsFound && updated->getProxy() == vtkChainMail::DeformationOf(this->proxy()))
      {
        this->Deformation = nullptr;
        this->placeWidget();
      }
    });
  this->placeWidget();
}

//------------------------------------------------------------------------------
void pqChainMailPoseWidget::hideHandles()
{
  // Those of its faces, which are for its size. Without them there is more of the faces to take hold of.
  vtkSMProxy* shown = this->widgetProxy()->GetRepresentationProxy();
  auto* box = vtkBoxRepresentation::SafeDownCast(shown ? shown->GetClientSideObject() : nullptr);
  if (box == nullptr)
  {
    return;
  }
  // VTK has a switch for all seven alone. The ball is the one in their midst.
  vtkNew<vtkPropCollection> props;
  box->GetActors(props);
  std::vector<vtkActor*> handles;
  vtkBoundingBox around;
  props->InitTraversal();
  while (vtkProp* prop = props->GetNextProp())
  {
    auto* actor = vtkActor::SafeDownCast(prop);
    if (actor && actor->GetProperty() == box->GetHandleProperty())
    {
      handles.push_back(actor);
      around.AddPoint(actor->GetCenter());
    }
  }
  double middle[3] = { 0.0, 0.0, 0.0 };
  around.GetCenter(middle);
  const auto fromMiddle = [&middle](vtkActor* handle)
  { return vtkMath::Distance2BetweenPoints(handle->GetCenter(), middle); };
  const auto ball = std::min_element(handles.begin(), handles.end(),
    [&fromMiddle](vtkActor* one, vtkActor* other) { return fromMiddle(one) < fromMiddle(other); });
  for (auto handle = handles.begin(); handle != handles.end(); ++handle)
  {
    (*handle)->SetVisibility(handle == ball);
  }
  box->SetOutlineCursorWires(0);
}

//------------------------------------------------------------------------------
vtkChainMail::Place pqChainMailPoseWidget::centre() const
{
  const std::vector<double> values = vtkSMUncheckedPropertyHelper(this->proxy(), "Position").GetDoubleArray();
  vtkChainMail::Place place{};
  std::copy_n(values.begin(), std::min<std::size_t>(3, values.size()), place.begin());
  return place;
}

//------------------------------------------------------------------------------
std::array<double, 6> pqChainMailPoseWidget::boundsOfBone()
{
  vtkSMProxy* deformation = vtkChainMail::DeformationOf(this->proxy());
  const vtkIdType body = vtkSMUncheckedPropertyHelper(this->proxy(), "Body").GetAsIdType();
  const vtkChainMail::Place centre = this->centre();
  const bool isKnown = this->Deformation == deformation && this->Body == body && (body >= 0 || this->Asked == centre);
  if (!isKnown)
  {
    this->Deformation = deformation;
    this->Body = body;
    this->Asked = centre;
    this->IsFound = deformation && vtkChainMail::FindBone(deformation, body, centre, this->Bone);
  }
  if (this->IsFound)
  {
    return this->Bone.Bounds;
  }
  auto* source = vtkSMSourceProxy::SafeDownCast(deformation);
  double half = EmptyHalf;
  if (source && source->GetOutputPortsCreated())
  {
    const double* b = source->GetDataInformation(0)->GetBounds();
    const double diagonal = std::hypot(b[1] - b[0], b[3] - b[2], b[5] - b[4]);
    half = b[0] <= b[1] && diagonal > 0.0 ? EmptyShare * diagonal : half;
  }
  return { { centre[0] - half, centre[0] + half, centre[1] - half, centre[1] + half, centre[2] - half,
    centre[2] + half } };
}

//------------------------------------------------------------------------------
void pqChainMailPoseWidget::placeWidget()
{
  std::array<double, 6> bounds = this->boundsOfBone();
  const vtkChainMail::Place centre = this->centre();
  for (std::size_t n = 0; n < 6; ++n)
  {
    bounds[n] -= centre[n / 2];
  }
  vtkSMProxy* box = this->widgetProxy();
  vtkSMPropertyHelper(box, "PlaceWidget").Set(bounds.data(), 6);
  box->UpdateVTKObjects();
  // Placed, it is where the bounds are; this moves and turns it again.
  this->widgetProxy()->GetRepresentationProxy()->UpdateVTKObjects();
  this->render();
}

//------------------------------------------------------------------------------
bool pqChainMailPoseWidget::hold(const std::vector<double>& ray)
{
  vtkSMProxy* deformation = vtkChainMail::DeformationOf(this->proxy());
  vtkChainMail::Bone bone;
  if (deformation == nullptr || !vtkChainMail::FindBone(deformation, ray, bone))
  {
    return false;
  }
  this->Deformation = deformation;
  this->Body = bone.Body;
  this->Asked = bone.Middle;
  this->Bone = bone;
  this->IsFound = true;
  const double none[3] = { 0.0, 0.0, 0.0 };
  vtkSMProxy* box = this->widgetProxy();
  vtkSMPropertyHelper(box, "Position").Set(bone.Middle.data(), 3);
  vtkSMPropertyHelper(box, "Rotation").Set(none, 3);
  box->UpdateVTKObjects();
  vtkSMUncheckedPropertyHelper(this->proxy(), "Position").Set(bone.Middle.data(), 3);
  vtkSMUncheckedPropertyHelper(this->proxy(), "Body").Set(bone.Body);
  this->placeWidget();
  Q_EMIT this->changeAvailable();
  return true;
}
