// Real height fields, which may not be committed.
#pragma once

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/rounds.h"

namespace fjell::test {

// Where a file of ../shared/data is, or empty; the test says that it was skipped.
inline std::string real(const std::string& name) {
    const char* data = std::getenv("FJELL_DATA");
    const std::string path = std::string(data ? data : FJELL_SOURCE_DIR "/../shared/data") + "/" + name;
    if (std::filesystem::exists(path)) return path;
    WARN("skipped: there is no " << path << " (set FJELL_DATA to the folder of real height fields)");
    return {};
}

// The same of a height field that takes many seconds, which is left to full rounds.
inline std::string large_real(const std::string& name) {
    const std::string path = real(name);
    if (path.empty() || full_rounds()) return path;
    WARN("skipped: " << path << " is large (FJELL_TEST_ROUNDS=full reads it)");
    return {};
}

} // namespace fjell::test
