#include "Builds.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace chainmail
{

Builds& Builds::ofProcess()
{
  static Builds builds;
  return builds;
}

Builds::~Builds()
{
  {
    const std::lock_guard<std::mutex> lock(this->mutex_);
    this->waiting_.clear();
  }
  for (std::thread& thread : this->threads_)
  {
    thread.join();
  }
}

void Builds::add(const std::shared_ptr<Build>& build)
{
  std::unique_lock<std::mutex> lock(this->mutex_);
  if (this->working_ == 0)
  {
    for (std::thread& thread : this->threads_)
    {
      thread.join(); // it has ended, or is about to
    }
    this->threads_.clear();
  }
  this->waiting_.push_back(build);
  // One core is left for the thread that uses the programs.
  if (this->working_ >= std::max(2u, std::thread::hardware_concurrency()) - 1)
  {
    return;
  }
  try
  {
    this->threads_.emplace_back([this] { this->work(); });
    ++this->working_;
  }
  catch (const std::system_error&)
  {
    if (this->working_ == 0)
    {
      this->waiting_.pop_back();
      lock.unlock();
      (*build)();
    }
  }
}

void Builds::finish()
{
  std::unique_lock<std::mutex> lock(this->mutex_);
  this->ended_.wait(lock, [this] { return this->working_ == 0; });
}

void Builds::hurry(const std::shared_ptr<Build>& build)
{
  const std::lock_guard<std::mutex> lock(this->mutex_);
  const auto found = std::find(this->waiting_.begin(), this->waiting_.end(), build);
  if (found != this->waiting_.end())
  {
    this->waiting_.splice(this->waiting_.begin(), this->waiting_, found);
  }
}

void Builds::work()
{
  for (;;)
  {
    std::shared_ptr<Build> build;
    {
      const std::lock_guard<std::mutex> lock(this->mutex_);
      if (this->waiting_.empty())
      {
        --this->working_;
        this->ended_.notify_all();
        return;
      }
      build = std::move(this->waiting_.front());
      this->waiting_.pop_front();
    }
    (*build)();
  }
}

}
