// A profile's keys as data: one table that the reader, the writer and controls go by.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/profile/keys.h"
#include "support/program.h"

using namespace fjell;
using namespace fjell::session;

namespace {

namespace fs = std::filesystem;

std::string dotted(const ProfileKey& key) {
    return fmt::format("{}.{}", key.table, key.name);
}

// Anywhere in the range, often at its ends, and over its orders of magnitude where it has some.
double random_value(const ProfileKey& key, std::mt19937_64& random) {
    const auto share = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    double value = random() % 8 == 0   ? key.least
                   : random() % 8 == 0 ? key.most
                   : key.logarithmic   ? (key.least + 1e-3) * std::pow(key.most / (key.least + 1e-3), share())
                                       : key.least + share() * (key.most - key.least);
    if (key.kind != KeyKind::number) value = std::round(value);
    return std::clamp(value, key.least, key.most);
}

Profile random_profile(std::mt19937_64& random) {
    Profile profile;
    for (const ProfileKey& key : profile_keys()) key.set(profile, random_value(key, random));
    if (!profile_conflict(profile).empty()) profile.refine.cull = true;
    return profile;
}

// Whether a profile of this one key is read, and what the key is then. line: gets what it is refused with.
bool reads(const ProfileKey& key, const std::string& value, double& read, std::string& line) {
    try {
        const Profile p = parse_profile(fmt::format("[{}]\n{} = {}\n", key.table, key.name, value), "p.toml");
        read = key.get(p);
        return true;
    } catch (const io::Failure& failure) {
        line = failure.what();
        return false;
    }
}

std::vector<fs::path> shipped() {
    std::vector<fs::path> files;
    for (const auto& file : fs::directory_iterator(FJELL_SOURCE_DIR "/profiles"))
        if (file.path().extension() == ".toml") files.push_back(file.path());
    return files;
}

std::string written_anew(const std::string& text) {
    return profile_text(parse_profile(text, "p.toml"), profile_heading(text));
}

} // namespace

TEST_CASE("what the budgets' keys say of bytes is what a slot costs") {
    const auto says = [](const char* name, std::size_t bytes) {
        for (const ProfileKey& key : profile_keys())
            if (std::string(key.table) == "budget" && std::string(key.name) == name)
                return std::string(key.about).find(fmt::format(" {} bytes each", bytes)) != std::string::npos;
        return false;
    };
    CHECK(says("vertices", cut_vertex_bytes));
    CHECK(says("triangles", cut_triangle_bytes));
}

TEST_CASE("every key has a name of its own, a range, a label, and says what it is with its range") {
    std::set<std::string> names, tables;
    for (const ProfileTable& table : profile_tables()) CHECK(tables.insert(table.name).second);
    std::size_t at = 0; // keys are in the order of their tables
    for (const ProfileKey& key : profile_keys()) {
        INFO(dotted(key));
        while (at < profile_tables().size() && std::string(profile_tables()[at].name) != key.table) ++at;
        REQUIRE(at < profile_tables().size());
        CHECK(names.insert(dotted(key)).second);
        CHECK(find_profile_key(dotted(key)) == &key);
        CHECK(std::string(key.label).size() > 2);
        CHECK(key.least < key.most);
        CHECK((key.kind == KeyKind::choice) == !key.choices.empty());
        CHECK((!key.zero || key.least == 0));
        const std::string about = key.about;
        CHECK(about.ends_with(key.about[about.size() - 1] == ')' ? ".)" : "."));
        if (key.kind == KeyKind::choice) {
            CHECK(key.most == static_cast<double>(key.choices.size() - 1));
            for (const char* choice : key.choices) CHECK(about.find(fmt::format("\"{}\"", choice)) != about.npos);
        } else if (key.kind != KeyKind::flag) {
            CHECK(about.find(fmt::format("{} to {}", key.least, key.most)) != about.npos);
        }
        if (key.zero && std::string(key.zero) != "none")
            CHECK(about.find(fmt::format("0: {}", key.zero)) != about.npos);
        CHECK((about.find("(Incremental") != about.npos) == (key.used_by == UsedBy::incremental));
        CHECK((about.find("(Recursive") != about.npos) == (key.used_by == UsedBy::recursive));
        CHECK((std::string(key.table) == "stream") == (key.used_by == UsedBy::streaming));
    }
    CHECK_FALSE(find_profile_key("refine"));
    CHECK_FALSE(find_profile_key("refine."));
    CHECK_FALSE(find_profile_key("error_px"));
    CHECK_FALSE(find_profile_key("view.error_px"));
}

TEST_CASE("setting a key changes it, to the last bit, and no other") {
    std::mt19937_64 random(401);
    for (int round = 0; round < 300; ++round)
        for (const ProfileKey& key : profile_keys()) {
            Profile profile = random_profile(random);
            const Profile before = profile;
            const double value = random_value(key, random);
            key.set(profile, value);
            CAPTURE(dotted(key), value);
            REQUIRE(key.get(profile) == value);
            const auto differing = differing_keys(before, profile);
            REQUIRE(differing.size() == (key.get(before) == value ? 0 : 1));
            if (!differing.empty()) REQUIRE(differing[0] == &key);
        }
}

TEST_CASE("a profile that is written reads back to the same values, and its heading too") {
    std::mt19937_64 random(402);
    for (int round = 0; round < 400; ++round) {
        const Profile profile = random_profile(random);
        std::string heading;
        for (std::size_t words = random() % 60; words > 0; --words)
            heading.append(heading.empty() ? 0 : 1, ' ').append(1 + random() % 12, static_cast<char>('a' + words % 26));
        const std::string text = profile_text(profile, heading);
        const Profile back = parse_profile(text, "p.toml");
        for (const ProfileKey& key : profile_keys()) {
            INFO(dotted(key));
            REQUIRE(key.get(back) == key.get(profile));
        }
        REQUIRE(profile_heading(text) == heading);
        REQUIRE(profile_text(back, heading) == text);
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) REQUIRE(line.size() <= 120);
    }
}

TEST_CASE("no heading makes anything else than a comment") {
    const Profile profile;
    for (const char* heading : {"", "\n", "a\nb = 1\n[x]\r\n", "\x01\x7f tab\there", "# ##", "[refine]"}) {
        const std::string text = profile_text(profile, heading);
        INFO(text);
        CHECK(differing_keys(parse_profile(text, "p.toml"), profile).empty());
        CHECK(profile_text(profile, profile_heading(text)) == text);
    }
    const std::string long_word(500, 'x');
    CHECK(profile_heading(profile_text(profile, "a " + long_word + " b")) == "a " + long_word + " b");
    CHECK(profile_heading("").empty());
    CHECK(profile_heading("#").empty());
    CHECK(profile_heading("# Mine") == "Mine");
    CHECK(profile_heading("[refine]\n# not this\n").empty());
    CHECK(profile_heading("# Of\r\n# mine.\r\n#\r\n# No more.\r\n") == "Of mine.");
}

TEST_CASE("values as text and back are the key's, and both readers enforce the table's range alike") {
    std::mt19937_64 random(403);
    for (const ProfileKey& key : profile_keys()) {
        INFO(dotted(key));
        const auto same = [&](const std::string& text, bool good) {
            INFO(text);
            double parsed = -77, read = -77;
            std::string line;
            const std::string problem = parse_value(key, text, parsed);
            CHECK(problem == (good ? "" : key_refusal(key)));
            CHECK(reads(key, text, read, line) == good);
            CHECK(parsed == read);
            if (!good) CHECK(line == fmt::format("p.toml:2: {}: {}", dotted(key), key_refusal(key)));
        };
        for (int round = 0; round < 50; ++round) {
            Profile profile;
            key.set(profile, random_value(key, random));
            if (!profile_conflict(profile).empty()) continue;
            double value = -77;
            CHECK(parse_value(key, value_text(key, profile), value).empty());
            CHECK(value == key.get(profile));
        }
        for (const char* text : {"nan", "-inf", "[1]", "{a = 1}", "1979-05-27", "\"magic\"", "''"}) same(text, false);
        if (key.kind == KeyKind::number || key.kind == KeyKind::whole) {
            const double step = key.kind == KeyKind::whole ? 1 : key.most * 1e-6;
            for (const double end : {key.least, key.most}) same(fmt::format("{}", end), true);
            for (const double beyond : {key.least - step, key.most + step}) same(fmt::format("{}", beyond), false);
            same("true", false);
        }
        if (key.kind == KeyKind::whole) same(fmt::format("{}.0", key.least), false);
        if (key.kind == KeyKind::flag || key.kind == KeyKind::choice) same("1", false);
        for (const char* choice : key.choices) {
            double value = -77;
            CHECK(parse_value(key, choice, value).empty());
            CHECK(std::string(choice) == key.choices[static_cast<std::size_t>(value)]);
        }
    }
}

TEST_CASE("a value that is typed in is one value and no more") {
    const ProfileKey& key = *find_profile_key("refine.max_error_px");
    for (const char* text : {"", " ", "1\nother = 2", "1 # two", "1, 2", "1 2", "= 1", "\"", "[[[[", "1\r"}) {
        double value = 3;
        INFO(text);
        CHECK(parse_value(key, text, value) == "must be a number from 0.01 to 1000 (pixels)");
        CHECK(value == 3);
    }
    double value = 3;
    CHECK(parse_value(key, " 2 ", value).empty());
    CHECK(value == 2);
    CHECK(key_refusal(*find_profile_key("refine.morph")) == "must be \"none\" or \"error\" or \"time\"");
    CHECK(key_refusal(*find_profile_key("budget.max_work")) == "must be a whole number from 0 to 4294967294");
}

TEST_CASE("the vertices that are shown are the chosen method's, and set for both") {
    const ProfileKey& key = *find_profile_key("budget.vertices");
    Profile profile;
    profile.budget.vertices = 100;
    profile.cut_budget.vertices = 200;
    CHECK(key.get(profile) == 200);
    profile.method = Method::recursive;
    CHECK(key.get(profile) == 100);
    key.set(profile, 300);
    CHECK(profile.budget.vertices == 300);
    CHECK(profile.cut_budget.vertices == 300);
}

// Change what keys say in runtime/profile/keys.cpp and write the files anew with
// FJELL_WRITE_PROFILES=1 build/release/bin/unit_profile_keys "every shipped profile*"
TEST_CASE("every shipped profile is what is written of it, to the last byte") {
    CHECK(shipped().size() == 4);
    for (const fs::path& file : shipped()) {
        INFO(file);
        if (std::getenv("FJELL_WRITE_PROFILES")) test::spit(file, written_anew(test::slurp(file)));
        const std::string text = test::slurp(file);
        CHECK(written_anew(text) == text);
        CHECK(profile_heading(text).size() > 10);
    }
}

TEST_CASE("keys that documents speak of exist") {
    std::vector<fs::path> documents{FJELL_SOURCE_DIR "/README.md"};
    for (const auto& file : fs::recursive_directory_iterator(FJELL_SOURCE_DIR "/docs"))
        if (file.path().extension() == ".md") documents.push_back(file.path());
    std::set<std::string> known;
    for (const ProfileKey& key : profile_keys()) known.insert(key.name);
    int found = 0;
    for (const fs::path& file : documents) {
        const std::string text = test::slurp(file);
        for (std::size_t at = text.find('`'); at != text.npos; at = text.find('`', at + 1)) { // `key = value`
            const std::size_t end = text.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789", at + 1);
            if (end == text.npos || end == at + 1 || text.substr(end, 3) != " = ") continue;
            INFO(file << ": " << text.substr(at, 40));
            CHECK(known.contains(text.substr(at + 1, end - at - 1)));
            ++found;
        }
    }
    CHECK(found >= 2);
}
