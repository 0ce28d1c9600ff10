/// Read by the leak checker of a sanitized build: PoCL, the compiler inside it and the OpenCL loader keep what they
/// allocate until the process ends.
extern "C" const char* __lsan_default_suppressions()
{
  return "leak:libpocl\nleak:libLLVM\nleak:libclang-cpp\nleak:libOpenCL\n";
}
