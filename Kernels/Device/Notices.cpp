#include "Notices.h"

#include <mutex>
#include <set>
#include <utility>

namespace chainmail
{

namespace
{

std::mutex mutex;
std::set<std::string> given;
std::vector<std::string> waiting;

}

void giveNotice(const std::string& text)
{
  const std::lock_guard<std::mutex> lock(mutex);
  if (given.insert(text).second)
  {
    waiting.push_back(text);
  }
}

std::vector<std::string> takeNotices()
{
  const std::lock_guard<std::mutex> lock(mutex);
  return std::exchange(waiting, {});
}

}
