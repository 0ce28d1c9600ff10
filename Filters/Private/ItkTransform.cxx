// SPDX-License-Identifier: BSD-3-Clause
#include "ItkTransform.h"

#include "Error.h"
#include "TextFile.h"

#include "vtkMath.h"
#include "vtkMatrix4x4.h"

#include <cmath>

namespace vtkChainMail
{

namespace
{

using chainmail::InputError;
using Matrix3 = std::array<double, 9>;

Matrix3 Product(const Matrix3& a, const Matrix3& b)
{
  Matrix3 product{};
  for (int i = 0; i < 3; ++i)
  {
    for (int j = 0; j < 3; ++j)
    {
      for (int k = 0; k < 3; ++k)
      {
        product[3 * i + j] += a[3 * i + k] * b[3 * k + j];
      }
    }
  }
  return product;
}

/// A rotation about one axis by the right-hand rule.
Matrix3 About(int axis, double angle)
{
  const int j = (axis + 1) % 3;
  const int k = (axis + 2) % 3;
  Matrix3 rotation{};
  rotation[3 * axis + axis] = 1.0;
  rotation[3 * j + j] = rotation[3 * k + k] = std::cos(angle);
  rotation[3 * j + k] = -std::sin(angle);
  rotation[3 * k + j] = std::sin(angle);
  return rotation;
}

Matrix3 OfQuaternion(double w, const double* xyz)
{
  const double q[4] = { w, xyz[0], xyz[1], xyz[2] };
  double rotation[3][3];
  vtkMath::QuaternionToMatrix3x3(q, rotation);
  Matrix3 matrix;
  for (int n = 0; n < 9; ++n)
  {
    matrix[n] = rotation[n / 3][n % 3];
  }
  return matrix;
}

/// The rotation of a versor: a unit quaternion with w >= 0, given by its vector part.
Matrix3 OfVersor(const double* xyz)
{
  return OfQuaternion(std::sqrt(std::max(0.0, 1.0 - vtkMath::Dot(xyz, xyz))), xyz);
}

/// One transform: x -> A (x - c) + c + t.
std::array<double, 16> MatrixOf(const ItkTransform& transform, std::array<double, 3>& centre)
{
  const std::string type = transform.Type.substr(0, transform.Type.find('_'));
  const std::vector<double>& p = transform.Parameters;
  const auto has = [&](std::size_t count)
  {
    if (p.size() != count)
    {
      throw InputError("a transform of type " + transform.Type + " needs " + std::to_string(count) +
                       " parameters, but the file has " + std::to_string(p.size()) + ".");
    }
  };
  if (!EndsWith(transform.Type, "_3_3"))
  {
    throw InputError("the transform is of type " + transform.Type +
                     ", which is not three-dimensional. Save a transform of three dimensions.");
  }
  Matrix3 linear = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 } };
  std::array<double, 3> shift = { { 0.0, 0.0, 0.0 } };
  const double* translation = nullptr;
  if (type == "AffineTransform" || type == "MatrixOffsetTransformBase" || type == "Rigid3DTransform")
  {
    has(12);
    std::copy(p.begin(), p.begin() + 9, linear.begin());
    translation = &p[9];
  }
  else if (type == "Euler3DTransform")
  {
    has(6);
    const bool isZYX = transform.Fixed.size() > 3 && transform.Fixed[3] != 0.0;
    linear = isZYX ? Product(About(2, p[2]), Product(About(1, p[1]), About(0, p[0])))
                   : Product(About(2, p[2]), Product(About(0, p[0]), About(1, p[1])));
    translation = &p[3];
  }
  else if (type == "VersorRigid3DTransform")
  {
    has(6);
    linear = OfVersor(p.data());
    translation = &p[3];
  }
  else if (type == "Similarity3DTransform")
  {
    has(7);
    linear = OfVersor(p.data());
    for (double& value : linear)
    {
      value *= p[6];
    }
    translation = &p[3];
  }
  else if (type == "VersorTransform")
  {
    has(3);
    linear = OfVersor(p.data());
  }
  else if (type == "QuaternionRigidTransform")
  {
    has(7);
    linear = OfQuaternion(p[3], p.data());
    translation = &p[4];
  }
  else if (type == "TranslationTransform")
  {
    has(3);
    translation = p.data();
  }
  else if (type != "IdentityTransform")
  {
    throw InputError("transforms of type " + transform.Type +
                     " cannot be read. Save the transform as an AffineTransform or a rigid transform.");
  }
  for (int a = 0; translation && a < 3; ++a)
  {
    shift[a] = translation[a];
  }
  for (std::size_t a = 0; a < 3 && a < transform.Fixed.size(); ++a)
  {
    centre[a] = transform.Fixed[a];
  }
  std::array<double, 16> matrix{};
  for (int i = 0; i < 3; ++i)
  {
    matrix[4 * i + 3] = centre[i] + shift[i];
    for (int j = 0; j < 3; ++j)
    {
      matrix[4 * i + j] = linear[3 * i + j];
      matrix[4 * i + 3] -= linear[3 * i + j] * centre[j];
    }
  }
  matrix[15] = 1.0;
  return matrix;
}

}

//------------------------------------------------------------------------------
BodyMotion MotionOf(const std::vector<ItkTransform>& transforms)
{
  const bool isComposite = !transforms.empty() && StartsWith(transforms[0].Type, "CompositeTransform");
  const std::size_t first = isComposite ? 1 : 0;
  if (transforms.size() <= first)
  {
    throw InputError("the file has no transform.");
  }
  if (!isComposite && transforms.size() > 1)
  {
    throw InputError("the file has " + std::to_string(transforms.size()) +
                     " transforms, but no CompositeTransform that combines them. Save a CompositeTransform, or one "
                     "file for each body.");
  }
  BodyMotion motion;
  vtkMatrix4x4::Identity(motion.Matrix.data());
  for (std::size_t n = first; n < transforms.size(); ++n)
  {
    std::array<double, 3> centre = { { 0.0, 0.0, 0.0 } };
    const std::array<double, 16> matrix = MatrixOf(transforms[n], centre);
    // The last transform is applied first.
    std::array<double, 16> product{};
    vtkMatrix4x4::Multiply4x4(motion.Matrix.data(), matrix.data(), product.data());
    motion.Matrix = product;
    // A centre of 0 means that the program chose none.
    motion.HasCentre = transforms.size() == first + 1 && vtkMath::Norm(centre.data()) > 0.0;
    motion.Centre = centre;
  }
  return motion;
}

}
