// Which sources name a compiler: runtime/src/shared/compiler.h does, fjell/export.h for public headers, and nothing
// else.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// What the standard lets begin with two underscores, and what the file may ask besides.
bool is_allowed(const std::string& path, const std::string& word) {
    static const Words standard{"__FILE__", "__LINE__", "__VA_ARGS__", "__cplusplus", "#pragma once"};
    static const std::map<std::string, Words> asked{
        // Arithmetic that a host must not compile with, by every compiler's name for it.
        {"runtime/include/fjell/view.h",
         {"__FAST_MATH__", "__ASSOCIATIVE_MATH__", "__FINITE_MATH_ONLY__", "_M_FP_FAST"}},
        {"baker/bake/bake.cpp", {"__GLIBC__"}}, // the C library, whose allocator is tuned
    };
    const auto in = [&](const Words& words) { return std::find(words.begin(), words.end(), word) != words.end(); };
    return in(standard) || (asked.contains(path) && in(asked.at(path)));
}

// Most lines have none, and the expressions take their time.
bool may_have_words(const std::string& line) {
    for (const char* part : {"__", "_M", "_mm", "_Pragma", "asm", "typeof", "gnu", "clang", "msvc", "#"})
        if (line.find(part) != std::string::npos) return true;
    return false;
}

// Words of single compilers in a source, comments and strings aside.
Words compiler_words(const std::string& path, const std::string& text) {
    static const std::regex quoted(R"("(?:[^"\\]|\\.)*"|//.*)");
    static const std::regex words(
        R"(\b__\w+|\b_Pragma\b|\b_(?:MSC|M)_\w+|\basm\b|\btypeof\b|\b(?:gnu|clang|msvc)::|\b_mm\d*_\w+)"
        R"(|#\s*pragma\s+\w+|#\s*include\s*<(?:\w*intrin|arm_neon|bits/[^>]*|ext/\w+_?\w*)\.h>)");
    Words found;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (!may_have_words(line)) continue;
        line = std::regex_replace(line, quoted, "\"\"");
        for (std::sregex_iterator word(line.begin(), line.end(), words), end; word != end; ++word)
            if (!is_allowed(path, word->str())) found.push_back(path + ": " + word->str());
    }
    return found;
}

} // namespace

TEST_CASE("one header for the library and one for hosts name a compiler, and no other source does") {
    const fs::path root = FJELL_SOURCE_DIR;
    Words found;
    int files = 0;
    for (const char* top : {"runtime", "baker", "editor", "content"})
        for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension(), path = fs::relative(entry.path(), root).string();
            if (path.starts_with("runtime/web/")) continue; // for a single compiler: Emscripten's
            if (extension != ".h" && extension != ".cpp" && extension != ".c" && extension != ".in") continue;
            ++files;
            std::ostringstream text;
            text << std::ifstream(entry.path()).rdbuf();
            // What older standard libraries lack, and compiler.h has.
            if (path.starts_with("runtime/src/") && path != "runtime/src/shared/compiler.h")
                for (const char* const lacking : {"std::bit_cast", "std::atomic_ref"})
                    if (text.str().find(lacking) != std::string::npos) found.push_back(path + ": " + lacking);
            const Words here = compiler_words(path, text.str());
            if (path == "runtime/src/shared/compiler.h" || path == "runtime/include/fjell/export.h")
                CHECK(!here.empty()); // it is still there that they stand
            else
                found.insert(found.end(), here.begin(), here.end());
        }
    CHECK(files > 300);
    CHECK(found == Words{});
}

TEST_CASE("words of a single compiler are found in code, and not in comments and strings") {
    const auto count = [](const std::string& text) { return compiler_words("a.cpp", text).size(); };
    for (const char* text :
         {"__builtin_prefetch(at);", "int f() __attribute__((pure));", "float* __restrict to;", "asm volatile(\"\");",
          "#pragma GCC ivdep", "_Pragma(\"once\")", "#if defined(_MSC_VER)", "#ifdef _M_ARM64", "__declspec(dllexport)",
          "[[nodiscard, gnu::pure]] int f();", "[[msvc::noinline]] void f();", "__atomic_load_n(&a, 0);",
          "unsigned __int128 wide;", "#include <immintrin.h>", "#include <bits/stdc++.h>", "_mm_pause();",
          "typeof(a) b;", "x = __FAST_MATH__;", "puts(\"\\\"\"); __sync_synchronize();"}) {
        INFO(text);
        CHECK(count(text) == 1);
    }
    for (const char* text : {"#pragma once", "a = __LINE__; // __builtin_trap()", "puts(\"asm \\\" __asm__\");",
                             "const int asmuch = 1;", "#include <bit>", "int a__b; // gnu::cold"}) {
        INFO(text);
        CHECK(count(text) == 0);
    }
    CHECK(compiler_words("runtime/include/fjell/view.h", "#if __FAST_MATH__").empty());
}
