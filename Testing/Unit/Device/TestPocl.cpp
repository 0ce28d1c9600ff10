// Special treatment of PoCL.

#include "Context.h"
#include "KernelSources.h"
#include "Pocl.h"

#include <gtest/gtest.h>

#include <cctype>

namespace
{

using namespace chainmail;

/// The names of all kernels, functions and built-in functions of a program with the types of their parameters, as the
/// longest text in the binary that has such names. A path follows them. Empty if there are none.
std::string namesIn(const std::string& bitcode)
{
  std::string longest, text;
  for (const char c : bitcode + '/')
  {
    if (std::isprint(static_cast<unsigned char>(c)) && c != '/')
    {
      text += c;
      continue;
    }
    if (text.size() > longest.size() && text.find("_Z") != std::string::npos)
    {
      longest = text;
    }
    text.clear();
  }
  return longest;
}

class Pocl : public testing::Test
{
protected:
  void SetUp() override
  {
    if (!isPocl(this->device))
    {
      GTEST_SKIP() << "this device is none of PoCL";
    }
  }

  std::string compiled(const std::string& source, const std::string& options, bool wholeHeader) const
  {
    return poclBitcode(this->device, source, "-cl-std=CL1.2" + options, wholeHeader);
  }

  const cl::Device device = findDevice("").device;
};

TEST_F(Pocl, KernelsCallTheFunctionsOfTheWholeHeader)
{
  const char* const kinds[] = { " -DWIDTH=8 -DAXES=1 -DPLASTIC -DWAVES",
    " -DWIDTH=8 -DAXES=3 -DROTATIONS -DVOLUMETRIC_STRAIN",
    " -DWIDTH=1 -DAXES=3 -DROTATIONS -DVOLUMETRIC_STRAIN -DFX=2 -DFY=2 -DFZ=2 -DOWNERS" };
  for (const std::string& file : detail::kernelFiles())
  {
    if (file.substr(file.rfind('.')) != ".cl")
    {
      continue;
    }
    int compiles = 0;
    for (const std::string kind : kinds) // some files have fewer kinds
    {
      const std::string options = " -DBX=32 -DBY=8 -DBZ=8 -DSKEW=272 -DCUTS" + kind, source = sourceOf(file);
      const std::string expected = namesIn(this->compiled(source, options, true));
      compiles += expected.empty() ? 0 : 1;
      EXPECT_EQ(namesIn(this->compiled(source, options, false)), expected) << file << kind;
    }
    EXPECT_GT(compiles, 0) << file;
  }
}

TEST_F(Pocl, AFunctionOfTheWholeHeaderAloneIsNotTakenForAnother)
{
  const std::string source = "kernel void k(global float* x) { *x = tgamma(*x); }";
  EXPECT_TRUE(this->compiled(source, "", false).empty());
  EXPECT_FALSE(this->compiled(source, "", true).empty());
}

}
