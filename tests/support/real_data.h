// Real height fields, which may not be committed.
#pragma once

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace fjell::test {

// Where a file of ../shared/data is, or empty; the test says that it was skipped.
inline std::string real(const std::string& name) {
    const char* data = std::getenv("FJELL_DATA");
    const std::string path = std::string(data ? data : FJELL_SOURCE_DIR "/../shared/data") + "/" + name;
    if (std::filesystem::exists(path)) return path;
    WARN("skipped: there is no " << path << " (set FJELL_DATA to the folder of real height fields)");
    return {};
}

} // namespace fjell::test
