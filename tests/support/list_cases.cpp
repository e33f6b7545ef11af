// Writes the names of the cases that ask for rounds (support/rounds.h) into the file that FJELL_ROUNDS_LIST names, a
// line each, as Catch2 reads them with --input-file; and of those that warn, because they do when they skip something,
// and what they need may have been installed by then. Where something asks before the first case, any of them may try
// more: then there is no list.
#define CATCH_CONFIG_EXTERNAL_INTERFACES // listeners
#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/rounds.h"

namespace fjell::test {

namespace {

std::string quoted(const std::string& name) {
    std::string text = "\"";
    for (const char c : name) {
        if (c == '"' || c == '\\' || c == ',' || c == '[') text += '\\';
        text += c;
    }
    return text + "\"\n";
}

class ListCases : public Catch::TestEventListenerBase {
public:
    using TestEventListenerBase::TestEventListenerBase;
    void testRunStarting(const Catch::TestRunInfo&) override { all_ = asked_for_rounds; }
    void testCaseStarting(const Catch::TestCaseInfo&) override { asked_for_rounds = false; }
    bool assertionEnded(const Catch::AssertionStats& stats) override {
        if (stats.assertionResult.getResultType() == Catch::ResultWas::Warning) asked_for_rounds = true;
        return false;
    }
    void testCaseEnded(const Catch::TestCaseStats& stats) override {
        if (asked_for_rounds) names_ += quoted(stats.testInfo.name);
    }
    void testRunEnded(const Catch::TestRunStats&) override {
        const char* const list = std::getenv("FJELL_ROUNDS_LIST");
        if (list == nullptr) return;
        if (all_)
            std::filesystem::remove(list);
        else
            std::ofstream(list) << names_;
    }

private:
    bool all_ = false;
    std::string names_;
};
CATCH_REGISTER_LISTENER(ListCases)

} // namespace

} // namespace fjell::test
