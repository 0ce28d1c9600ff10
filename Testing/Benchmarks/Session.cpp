#include "Session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>

namespace bench
{

namespace
{

constexpr int skipStatus = 125; // as Testing/CMakeLists.txt tells ctest

std::string optionOf(int argc, char** argv, const std::string& name, const std::string& otherwise)
{
  const std::string prefix = "--" + name + "=";
  for (int n = 1; n < argc; ++n)
  {
    const std::string argument = argv[n];
    if (argument.compare(0, prefix.size(), prefix) == 0)
    {
      return argument.substr(prefix.size());
    }
  }
  return otherwise;
}

bool hasOption(int argc, char** argv, const std::string& name)
{
  return std::any_of(argv + 1, argv + argc, [&](const char* argument) { return argument == "--" + name; });
}

std::string environment(const char* name)
{
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// A string of JSON. Control characters do not come up in names.
std::string quoted(const std::string& text)
{
  std::string result = "\"";
  for (const char c : text)
  {
    if (c == '"' || c == '\\')
    {
      result += '\\';
    }
    result += c;
  }
  return result + '"';
}

/// A finite number.
std::string number(double value)
{
  std::ostringstream text;
  text.precision(9);
  text << value;
  return text.str();
}

/// An option that is a whole number of 0 or more.
std::uint64_t numberOf(int argc, char** argv, const std::string& name, const std::string& otherwise)
{
  const std::string text = optionOf(argc, argv, name, otherwise);
  if (text.empty() || text.size() > 18 || text.find_first_not_of("0123456789") != std::string::npos)
  {
    throw std::runtime_error("--" + name + "=" + text + " is no whole number of at most 18 digits");
  }
  return std::stoull(text);
}

std::string now()
{
  const std::time_t seconds = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&seconds));
  return text;
}

}

double median(std::vector<double> values)
{
  if (values.empty())
  {
    throw std::logic_error("the median of nothing");
  }
  const std::size_t middle = values.size() / 2;
  std::sort(values.begin(), values.end());
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

Session::Session(int argc, char** argv, std::string id, std::string title)
  : id_(std::move(id))
  , title_(std::move(title))
  , small_(hasOption(argc, argv, "small"))
  , size_(static_cast<int>(numberOf(argc, argv, "size", "0")))
  , repeats_(std::max(1, static_cast<int>(numberOf(argc, argv, "repeats", this->small_ ? "2" : "5"))))
  , seed_(numberOf(argc, argv, "seed", "1"))
  , device_(optionOf(argc, argv, "device", environment("CHAINMAIL_TEST_DEVICE")))
  , json_(optionOf(argc, argv, "json", ""))
  , machine_(this->device_, this->small_)
{
  std::cout << this->id_ << ": " << this->title_ << "\n"
            << this->machine_.device() << " (" << this->machine_.platform() << "), " << processor() << ", load "
            << load() << "\n";
}

std::vector<int> Session::sizes(const std::vector<int>& all) const
{
  constexpr int smallSize = 24;
  return this->size_ > 0 ? std::vector<int>{ this->size_ } : this->small_ ? std::vector<int>{ smallSize } : all;
}

chainmail::Simulation Session::simulate(std::shared_ptr<const chainmail::Model> model, chainmail::Settings settings)
{
  settings.device = this->device_;
  return chainmail::Simulation(std::move(model), settings);
}

double Session::once(const Task& task) const
{
  if (task.prepare)
  {
    task.prepare();
  }
  const auto begin = std::chrono::steady_clock::now();
  task.run();
  const auto end = std::chrono::steady_clock::now();
  if (task.check)
  {
    task.check();
  }
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

std::vector<std::vector<double>> Session::time(const std::vector<Task>& tasks) const
{
  std::vector<std::vector<double>> milliseconds(tasks.size());
  for (int round = -1; round < this->repeats_; ++round)
  {
    for (std::size_t n = 0; n < tasks.size(); ++n)
    {
      const double elapsed = this->once(tasks[n]);
      if (round >= 0)
      {
        milliseconds[n].push_back(elapsed);
      }
    }
  }
  return milliseconds;
}

void Session::report(const Result& result)
{
  std::vector<double> values = result.milliseconds;
  for (const auto& [name, value] : result.figures)
  {
    values.push_back(value);
  }
  if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }))
  {
    throw std::runtime_error("a figure to be reported is not finite");
  }
  const Entry entry{ result, this->machine_.measure(), load() };
  std::cout << "  " << result.scene << ", " << result.method << ": ";
  if (!result.milliseconds.empty())
  {
    const auto [low, high] = std::minmax_element(result.milliseconds.begin(), result.milliseconds.end());
    std::cout << median(result.milliseconds) << " ms (" << *low << " to " << *high << "); ";
  }
  for (const auto& [name, value] : result.figures)
  {
    std::cout << name << " " << value << "; ";
  }
  std::cout << "triad " << entry.bandwidth.deviceTriad << " GB/s, copy " << entry.bandwidth.deviceCopy << " GB/s"
            << std::endl;
  this->entries_.push_back(entry);
  this->write();
}

void Session::write() const
{
  if (this->json_.empty())
  {
    return;
  }
  std::ostringstream text;
  text << "{\"benchmark\": " << quoted(this->id_) << ", \"title\": " << quoted(this->title_)
       << ", \"device\": " << quoted(this->machine_.device()) << ", \"platform\": " << quoted(this->machine_.platform())
       << ", \"computeUnits\": " << this->machine_.computeUnits()
       << ", \"gpu\": " << (this->machine_.gpu() ? "true" : "false") << ", \"processor\": " << quoted(processor())
       << ", \"date\": " << quoted(now()) << ", \"small\": " << (this->small_ ? "true" : "false") << ", \"results\": [";
  const char* separator = "\n";
  for (const Entry& entry : this->entries_)
  {
    text << separator << "  {\"scene\": " << quoted(entry.result.scene)
         << ", \"method\": " << quoted(entry.result.method) << ", \"milliseconds\": [";
    separator = "";
    for (const double value : entry.result.milliseconds)
    {
      text << separator << number(value);
      separator = ", ";
    }
    text << "], \"figures\": {";
    separator = "";
    for (const auto& [name, value] : entry.result.figures)
    {
      text << separator << quoted(name) << ": " << number(value);
      separator = ", ";
    }
    text << "}, \"triad\": " << number(entry.bandwidth.deviceTriad)
         << ", \"copy\": " << number(entry.bandwidth.deviceCopy)
         << ", \"hostTriad\": " << number(entry.bandwidth.hostTriad)
         << ", \"hostCopy\": " << number(entry.bandwidth.hostCopy) << ", \"load\": " << number(entry.load) << "}";
    separator = ",\n";
  }
  text << "\n]}\n";
  std::ofstream file(this->json_);
  file << text.str();
  if (!file.flush())
  {
    throw std::runtime_error("could not write " + this->json_);
  }
}

double roundingOf(double largestDisplacement)
{
  return std::max(1e-5, std::numeric_limits<float>::epsilon() * largestDisplacement);
}

void requireSound(const chainmail::Simulation& simulation)
{
  std::vector<float> u(3 * simulation.model().grid().voxels());
  simulation.displacements(u.data());
  double largest = 0.0; // fraction of the spacing
  for (std::size_t n = 0; n < u.size(); ++n)
  {
    if (!std::isfinite(u[n]))
    {
      throw std::runtime_error("a displacement is not finite");
    }
    largest = std::max(largest, std::fabs(u[n]) / simulation.model().grid().spacing[n % 3]);
  }
  const chainmail::Statistics statistics = simulation.measure();
  const double rounding = roundingOf(largest);
  if (!std::isfinite(statistics.energy) || !(statistics.maxLinkExcess <= rounding))
  {
    throw std::runtime_error("a link is longer than its limit by " + std::to_string(statistics.maxLinkExcess) +
                             " of the spacing, where rounding allows " + std::to_string(rounding));
  }
}

int run(
  int argc, char** argv, const std::string& id, const std::string& title, const std::function<void(Session&)>& body)
{
  try
  {
    Session session(argc, argv, id, title);
    body(session);
    return EXIT_SUCCESS;
  }
  catch (const Skip& skip)
  {
    std::cout << "skipped: " << skip.what() << std::endl;
    return skipStatus;
  }
  catch (const std::exception& error)
  {
    std::cerr << "nothing is reported: " << error.what() << std::endl;
    return EXIT_FAILURE;
  }
}

}
