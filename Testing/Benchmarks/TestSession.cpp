// What benchmarks report, and what they refuse to.

#include "../TemporaryFolder.h"
#include "Blocks.h"
#include "Session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace
{

using namespace chainmail;

int runWith(const std::vector<std::string>& options, const std::function<void(bench::Session&)>& body)
{
  std::vector<std::string> words{ "test", "--small" };
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> argv;
  for (std::string& word : words)
  {
    argv.push_back(word.data());
  }
  return bench::run(static_cast<int>(argv.size()), argv.data(), "T", "a \"test\"", body);
}

TEST(Session, RefusesLinksBeyondTheirLimits)
{
  bench::Block block({ 12, 12, 12 });
  block.anchors.faces[0] = true;
  const int status = runWith({},
    [&](bench::Session& session)
    {
      Simulation simulation = session.simulate(block.model());
      simulation.pull({ bench::probeAt({ 8, 6, 6 }, { 1.5, 1.0, 0.0 }) });
      EXPECT_NO_THROW(bench::requireSound(simulation));
      simulation.setRelaxation(RelaxationMethod::Paper, 1.0);
      simulation.relax(20, 0.0);
      EXPECT_GT(simulation.measure().maxLinkExcess, 0.1);
      bench::requireSound(simulation);
    });
  EXPECT_EQ(status, 1);
}

TEST(Session, RefusesFiguresThatAreNotFinite)
{
  const TemporaryFolder folder;
  const std::string path = (folder.path / "session.json").string();
  const auto report = [](double value) {
    return [value](bench::Session& s) { s.report({ "s", "m", {}, { { "f", value } } }); };
  };
  EXPECT_EQ(runWith({}, report(std::nan(""))), 1);
  EXPECT_EQ(runWith({ "--json=" + path }, report(2.0)), 0);
  EXPECT_EQ(runWith({ "--json=/nowhere/at/all.json" }, report(2.0)), 1);
}

TEST(Session, TellsCtestThatItSkips)
{
  EXPECT_EQ(runWith({}, [](bench::Session&) { throw bench::Skip("nothing here"); }), 125);
  EXPECT_EQ(runWith({ "--device=there is no such device" }, [](bench::Session&) {}), 1);
}

TEST(Session, TimesTasksInTurnAfterARoundThatDoesNotCount)
{
  runWith({ "--repeats=3" },
    [](bench::Session& session)
    {
      std::string order;
      const auto task = [&](char name)
      {
        return bench::Task{ [&order, name] { order += name; }, [&order, name] { order += char(name + 1); },
          [&order, name] { order += char(name + 2); } };
      };
      const auto milliseconds = session.time({ task('a'), task('x') });
      EXPECT_EQ(order, "abcxyzabcxyzabcxyzabcxyz");
      EXPECT_EQ(milliseconds.size(), 2u);
      EXPECT_EQ(milliseconds[0].size(), 3u);
    });
}

TEST(Session, WritesWhatItWasToldTo)
{
  const TemporaryFolder folder;
  const std::string path = (folder.path / "session.json").string();
  EXPECT_EQ(runWith({ "--json=" + path },
              [](bench::Session& session) {
                session.report({ "a scene", "a method", { 1.5, 2.5 }, { { "figure", 7.0 } } });
              }),
    0);
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  for (const char* part : { "\"benchmark\": \"T\"", "\"title\": \"a \\\"test\\\"\"", "\"milliseconds\": [1.5, 2.5]",
         "\"figures\": {\"figure\": 7}", "\"small\": true" })
  {
    EXPECT_NE(text.str().find(part), std::string::npos) << part << " in " << text.str();
  }
}

TEST(Session, MedianOfSamples)
{
  EXPECT_EQ(bench::median({ 3.0, 1.0, 2.0 }), 2.0);
  EXPECT_EQ(bench::median({ 4.0, 1.0, 2.0, 3.0 }), 2.5);
  EXPECT_THROW(bench::median({}), std::logic_error);
}

TEST(Session, MemoryMoves)
{
  bench::Machine machine("", true);
  const bench::Bandwidth bandwidth = machine.measure();
  for (const double value : { bandwidth.deviceTriad, bandwidth.deviceCopy, bandwidth.hostTriad, bandwidth.hostCopy })
  {
    EXPECT_GT(value, 0.01);
    EXPECT_LT(value, 1e5);
  }
}

}
