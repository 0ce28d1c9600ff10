// What memory can do on this machine, in OpenCL and in plain C++ on all cores: the limits that sweeps are compared
// with.

#include "Session.h"

int main(int argc, char** argv)
{
  return bench::run(argc, argv, "Machine", "memory bandwidth",
    [](bench::Session& session)
    {
      for (int n = 0; n < 3; ++n)
      {
        const bench::Bandwidth bandwidth = session.machine().measure();
        session.report({ "streaming", "pass " + std::to_string(n + 1), {},
          { { "OpenCL triad [GB/s]", bandwidth.deviceTriad }, { "OpenCL copy [GB/s]", bandwidth.deviceCopy },
            { "C++ triad [GB/s]", bandwidth.hostTriad }, { "C++ copy [GB/s]", bandwidth.hostCopy } } });
      }
    });
}
