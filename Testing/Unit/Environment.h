#pragma once

#include <cstdlib>
#include <optional>
#include <string>

/// Sets an environment variable, or removes it (null), until its destruction.
class Variable
{
public:
  Variable(const std::string& name, const char* value)
    : name_(name)
  {
    if (const char* before = std::getenv(name.c_str()))
    {
      this->before_ = before;
    }
    this->set(value);
  }
  ~Variable() { this->set(this->before_ ? this->before_->c_str() : nullptr); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

private:
  void set(const char* value) const
  {
#ifdef _WIN32
    _putenv_s(this->name_.c_str(), value ? value : ""); // Windows has no empty variables
#else
    value ? setenv(this->name_.c_str(), value, 1) : unsetenv(this->name_.c_str());
#endif
  }

  std::string name_;
  std::optional<std::string> before_;
};
