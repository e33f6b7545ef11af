// Variables of the environment, for as long as a test needs them.
#pragma once

#include <cstdlib>
#include <string>

namespace fjell::test {

// While it lives, a variable of the environment is another value; null: it is not set.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) {
        if (const char* const before = std::getenv(name)) before_ = before, was_set_ = true;
        value != nullptr ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Variable() { was_set_ ? setenv(name_, before_.c_str(), 1) : unsetenv(name_); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    const char* name_;
    std::string before_;
    bool was_set_ = false;
};

} // namespace fjell::test
