// How much random tests do (support/rounds.h).
#include <cstdlib>
#include <string>

#include <catch2/catch.hpp>

#include "support/rounds.h"

using namespace fjell::test;

namespace {

// The environment as it was, afterwards.
class Set {
public:
    Set(const char* name, const char* value) : name_(name) {
        if (const char* const was = std::getenv(name)) was_ = was, there_ = true;
        value != nullptr ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Set() { there_ ? setenv(name_, was_.c_str(), 1) : unsetenv(name_); }
    Set(const Set&) = delete;
    Set& operator=(const Set&) = delete;

private:
    const char* name_;
    std::string was_;
    bool there_ = false;
};

} // namespace

TEST_CASE("rounds are few, all of them, or so many times the few; a step stays what it is") {
    const Set brief("FJELL_TEST_ROUNDS", nullptr), no_limit("FJELL_TEST_TIMES", nullptr);
    CHECK((rounds(6, 60) == 6 && rounds(13, 1) == 13 && first_of(2, {1, 2, 3}).size() == 2));
    const Set full("FJELL_TEST_ROUNDS", "full");
    CHECK((rounds(6, 60) == 60 && rounds(13, 1) == 1 && first_of(2, {1, 2, 3}).size() == 3));
    const Set times("FJELL_TEST_TIMES", "4");
    CHECK((rounds(6, 60) == 24 && rounds(20, 60) == 60 && rounds(0, 3) == 0 && rounds(13, 1) == 1));
    CHECK(first_of(2, {1, 2, 3}).size() == 3);
    const Set nothing("FJELL_TEST_TIMES", "0");
    CHECK(rounds(6, 60) == 6); // never none
}
