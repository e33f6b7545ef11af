// Journals: what was confirmed is there again, whatever was cut off or flipped after it; what cannot be one is refused
// in one line.
#include <catch2/catch.hpp>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "io/file.h"
#include "io/stamps.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

PackHeader some_pack(std::uint64_t hash = 7) {
    PackHeader h{};
    h.directory_hash = hash;
    h.columns = h.rows = 129;
    h.spacing_m[0] = h.spacing_m[1] = h.crs_step[0] = h.crs_step[1] = 10;
    h.crs_origin[0] = 500'000, h.crs_origin[1] = 7'000'000;
    return h;
}

io::KeptStamp some_stamp(Random& random) {
    Stamp s;
    s.x_m = uniform(random, -10, 1300), s.z_m = uniform(random, -10, 1300);
    s.radius_m = static_cast<float>(uniform(random, 1, 90)), s.falloff_m = static_cast<float>(uniform(random, 0, 9));
    s.strength = static_cast<float>(uniform(random, 0, 1));
    const StampPoint points[] = {{1, 2, 3}, {40, 50, 60}, {70, 8, 9}};
    const float heights_m[] = {1, std::numeric_limits<float>::quiet_NaN(), 3, 4, 5, 6};
    const std::uint8_t mask[] = {0, 1, 2, 253, 254, 255};
    switch (pick(random, 0, 4)) {
    case 4: s.shape = StampShape::lock, s.amount_m = 0.25f, s.points = points, s.point_count = 2; break;
    case 0: s.shape = StampShape::crater, s.amount_m = 3, s.morph_s = 0.5f; break;
    case 1: s.shape = StampShape::path, s.points = points, s.point_count = 3; break;
    case 2: s.shape = StampShape::noise, s.wavelength_m = 25, s.seed = 0xffff'ffff, s.amount_m = -2; break;
    default:
        s.shape = StampShape::heights, s.first = {-1, 4}, s.columns = 3, s.rows = 2;
        s.heights_m = heights_m, s.mask = mask;
    }
    return io::KeptStamp(s);
}

// All that a journal says, as text; NaN as null.
std::string told(const io::Journal& journal) {
    std::string text;
    for (const io::JournalLayer& layer : journal.layers()) {
        text += std::to_string(layer.id) + " " + layer.name + (layer.on ? " on " : " off ") +
                std::to_string(layer.strength) + "\n";
        for (const io::JournalStamp& stamp : layer.stamps)
            text += std::to_string(stamp.id) + " " + io::write_stamps({{0, stamp.what}});
    }
    return text;
}

// A random change, of those that a journal takes.
void change(Random& random, io::Journal& journal) {
    const auto layers = journal.layers();
    const auto any_layer = [&]() -> const io::JournalLayer& {
        return layers[static_cast<std::size_t>(pick(random, 0, static_cast<int>(layers.size()) - 1))];
    };
    const int what = layers.empty() ? 0 : pick(random, 0, 9);
    if (what == 0) {
        (void)journal.add_layer("layer " + std::to_string(pick(random, 0, 999)));
    } else if (what == 1) {
        io::JournalLayer layer = any_layer();
        layer.on = !layer.on, layer.strength = static_cast<float>(uniform(random, 0, 1)), layer.name += "!";
        journal.set_layer(layer, static_cast<std::size_t>(pick(random, 0, static_cast<int>(layers.size()) - 1)));
    } else if (what == 2 && layers.size() > 2) {
        journal.remove_layer(any_layer().id);
    } else if (what == 3) {
        std::vector<std::uint64_t> ids;
        for (const io::JournalLayer& layer : layers)
            for (const io::JournalStamp& stamp : layer.stamps)
                if (pick(random, 0, 4) == 0) ids.push_back(stamp.id);
        journal.remove_stamps(ids);
    } else {
        std::vector<io::KeptStamp> stamps;
        for (int i = pick(random, 0, 3); i >= 0; --i) stamps.push_back(some_stamp(random));
        (void)journal.add_stamps(any_layer().id, stamps);
    }
}

std::vector<char> bytes_of(const std::string& path) {
    const std::string text = io::read_text(path);
    return {text.begin(), text.end()};
}
void write(const std::string& path, std::span<const char> bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

template <typename Call>
std::string journal_refusal(const Call& call) {
    try {
        call();
    } catch (const io::Failure& failure) {
        return std::to_string(failure.exit_code) + " " + failure.what();
    }
    return "";
}

} // namespace

TEST_CASE("a journal says after it was opened again what it said before, compacted or not") {
    Random random(45);
    for (int round = 0; round < rounds(20, 300); ++round) {
        const TemporaryFolder folder;
        const std::string path = io::journal_path(folder / "pack.fjell");
        std::string before;
        for (int session = 0; session < 3; ++session) {
            io::Journal journal(path, some_pack());
            CHECK((told(journal) == before && journal.dropped_bytes() == 0));
            for (int i = pick(random, 0, 20); i > 0; --i) change(random, journal);
            journal.commit();
            before = told(journal);
            CHECK(told(io::Journal(path, some_pack(), io::JournalAccess::read)) == before);
            if (pick(random, 0, 1) == 0) continue;
            const std::uint64_t bytes = journal.file_bytes(), dead = journal.dead_bytes();
            journal.compact();
            CHECK((told(journal) == before && journal.file_bytes() == bytes - dead && journal.dead_bytes() == 0));
            CHECK(journal.file_bytes() == std::filesystem::file_size(path));
        }
    }
}

TEST_CASE("a journal that is cut off at any byte has all of its whole records, and goes on from there") {
    Random random(46);
    const TemporaryFolder folder;
    const std::string path = folder / "whole.journal", part = folder / "part.journal";
    std::vector<std::pair<std::uint64_t, std::string>> states; // how long the file was, and what it said
    {
        io::Journal journal(path, some_pack());
        for (int i = 0; i < 12; ++i) {
            states.emplace_back(journal.file_bytes(), told(journal));
            change(random, journal);
        }
        states.emplace_back(journal.file_bytes(), told(journal));
    }
    const std::vector<char> whole = bytes_of(path);
    REQUIRE(states.back().first == whole.size());
    for (std::size_t length = 0; length < whole.size(); ++length) {
        write(part, std::span(whole).first(length));
        if (length < states.front().first) {
            CHECK(!journal_refusal([&] { (void)io::Journal(part, some_pack()); }).empty());
            continue;
        }
        std::size_t last = 0;
        while (last + 1 < states.size() && states[last + 1].first <= length) ++last;
        INFO("cut at " << length);
        CHECK(told(io::Journal(part)) == states[last].second);
        io::Journal journal(part, some_pack());
        CHECK((told(journal) == states[last].second && journal.dropped_bytes() == length - states[last].first));
        (void)journal.add_layer("after");
        CHECK(told(io::Journal(part)) == told(journal));
    }
}

TEST_CASE("a bit that flips in a journal is never read as something else") {
    Random random(47);
    const TemporaryFolder folder;
    const std::string path = folder / "whole.journal", flipped = folder / "flipped.journal";
    std::vector<std::string> said;
    {
        io::Journal journal(path, some_pack());
        for (int i = 0; i < 8; ++i) {
            said.push_back(told(journal));
            change(random, journal);
        }
        said.push_back(told(journal));
    }
    const std::vector<char> whole = bytes_of(path);
    const std::size_t step = static_cast<std::size_t>(rounds(13, 1));
    for (std::size_t bit = 0; bit < whole.size() * 8; bit += step) {
        std::vector<char> bytes = whole;
        bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ 1 << bit % 8);
        write(flipped, bytes);
        std::string now;
        const std::string refused = journal_refusal([&] { now = told(io::Journal(flipped)); });
        // A flipped zero that fills up a record is no harm; one in the last record looks like one that was not
        // finished.
        INFO("bit " << bit << ": " << refused);
        CHECK((!refused.empty() || now == said.back() || now == said[said.size() - 2]));
        CHECK(bytes_of(flipped) == bytes); // reading leaves it as it is
    }
}

TEST_CASE("layers of a journal apply from the bottom to the top, with their strengths, unless they are off") {
    const TemporaryFolder folder;
    io::Journal journal(folder / "j", some_pack());
    const std::uint32_t low = journal.add_layer("low"), high = journal.add_layer("high");
    const auto raise = [](float amount_m) {
        Stamp s;
        s.radius_m = 5, s.amount_m = amount_m, s.strength = 0.5f;
        return io::KeptStamp(s);
    };
    (void)journal.add_stamp(high, raise(1));
    const std::uint64_t gone = journal.add_stamp(low, raise(2));
    (void)journal.add_stamp(low, raise(3));
    const auto amounts = [&] {
        std::vector<float> all;
        for (const io::KeptStamp& stamp : journal.stamps()) all.push_back(stamp.plain.amount_m * stamp.plain.strength);
        return all;
    };
    CHECK(amounts() == std::vector<float>{1, 1.5f, 0.5f});
    io::JournalLayer layer = journal.layers()[0];
    layer.strength = 0.5f;
    journal.set_layer(layer, 1);
    CHECK(amounts() == std::vector<float>{0.5f, 0.5f, 0.75f});
    journal.remove_stamps(std::vector{gone});
    layer.on = false;
    journal.set_layer(layer, 1);
    CHECK(amounts() == std::vector<float>{0.5f});
    layer.on = true;
    journal.set_layer(layer, 1);
    CHECK(amounts() == std::vector<float>{0.5f, 0.75f});
    journal.remove_layer(high);
    CHECK(amounts() == std::vector<float>{0.75f});
}

TEST_CASE("what a journal cannot take is refused in one line, and changes nothing") {
    const TemporaryFolder folder;
    const std::string path = folder / "j";
    Random random(48);
    io::Journal journal(path, some_pack());
    const std::uint32_t layer = journal.add_layer("one");
    const std::uint64_t stamp = journal.add_stamp(layer, some_stamp(random));
    const std::string before = told(journal);
    const std::vector<char> bytes = bytes_of(path);
    const auto refused = [&](const std::string& part, const auto& call) {
        const std::string what = journal_refusal(call);
        INFO(what);
        CHECK((what.starts_with("1 ") && what.find(part) != std::string::npos));
        CHECK((what.find('\n') == std::string::npos && told(journal) == before && bytes_of(path) == bytes));
    };
    refused("no layer 9", [&] { (void)journal.add_stamp(9, some_stamp(random)); });
    refused("no layer 9", [&] { journal.remove_layer(9); });
    refused("1 to 200 bytes", [&] { (void)journal.add_layer(""); });
    refused("1 to 200 bytes", [&] { (void)journal.add_layer(std::string(201, 'x')); });
    io::JournalLayer changed = journal.layers()[0];
    refused("place", [&] { journal.set_layer(changed, 1); });
    changed.strength = std::numeric_limits<float>::quiet_NaN();
    refused("strength", [&] { journal.set_layer(changed, 0); });
    refused("not there", [&] { journal.remove_stamps(std::vector<std::uint64_t>{stamp, stamp + 1}); });
    refused("named twice", [&] { journal.remove_stamps(std::vector<std::uint64_t>{stamp, stamp}); });
    io::KeptStamp bad = some_stamp(random);
    bad.plain.x_m = std::numeric_limits<double>::infinity();
    refused("Stamp::x_m", [&] { (void)journal.add_stamp(layer, bad); });
    bad = {};
    bad.plain.shape = StampShape::heights, bad.plain.columns = 2, bad.plain.rows = 2, bad.heights_m = {1, 2, 3};
    refused("Stamp::heights_m", [&] { (void)journal.add_stamp(layer, bad); });
    refused("another program", [&] { (void)io::Journal(path, some_pack()); });
    refused("another pack", [&] { (void)io::Journal(path, some_pack(8), io::JournalAccess::read); });
    io::Journal reading(path, some_pack(), io::JournalAccess::read);
    refused("read only", [&] { (void)reading.add_layer("two"); });
    refused("No such file", [&] { (void)io::Journal(folder / "none", some_pack(), io::JournalAccess::read); });
    write(folder / "text", std::string("{\"stamps\": []}"));
    refused("is no journal", [&] { (void)io::Journal(folder / "text"); });
    CHECK((io::is_journal(path) && !io::is_journal(folder / "text") && !io::is_journal(folder / "none")));
}

TEST_CASE("a journal that is carried over to another pack of the same ground has its places there") {
    const TemporaryFolder folder;
    Random random(49);
    std::vector<io::KeptStamp> before;
    {
        io::Journal journal(folder / "old", some_pack());
        const std::uint32_t layer = journal.add_layer("one");
        for (int i = 0; i < 30; ++i) (void)journal.add_stamp(layer, some_stamp(random));
        before = journal.stamps();
    }
    PackHeader other = some_pack(9);
    other.crs_origin[0] -= 30, other.crs_origin[1] += 50; // three samples west, five north
    io::rebase_journal(folder / "old", other, folder / "new");
    const std::vector<io::KeptStamp> after = io::Journal(folder / "new", other).stamps();
    REQUIRE(after.size() == before.size());
    for (std::size_t i = 0; i < after.size(); ++i) {
        const Stamp a = before[i].stamp(), b = after[i].stamp();
        CHECK((b.x_m == a.x_m + 30 && b.z_m == a.z_m + 50));
        CHECK((b.first.column == a.first.column + 3 && b.first.row == a.first.row + 5));
        for (std::uint32_t p = 0; p < a.point_count; ++p)
            CHECK((b.points[p].x_m == a.points[p].x_m + 30 && b.points[p].z_m == a.points[p].z_m + 50));
    }
    other.crs_origin[0] += 4;
    CHECK(journal_refusal([&] { io::rebase_journal(folder / "old", other, folder / "bad"); }).find("samples apart") !=
          std::string::npos);
    other = some_pack(9), other.spacing_m[0] = 9;
    CHECK(journal_refusal([&] { io::rebase_journal(folder / "old", other, folder / "bad"); }).find("one spacing") !=
          std::string::npos);
    CHECK(!std::filesystem::exists(folder / "bad"));
}
