#include "io/set_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/system.h"

namespace fjell::io {

namespace {

constexpr int most_depth = 32; // of values that are skipped

class Reader {
public:
    Reader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

    [[noreturn]] void fail(const std::string& what) const {
        const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
        throw Failure(1, name_ + ":" + std::to_string(line) + ": " + what);
    }

    // The next character that means something; 0 at the end.
    char peek() {
        while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool take(char c) {
        if (peek() != c) return false;
        ++at_;
        return true;
    }
    void expect(char c) {
        if (!take(c))
            fail(std::string("expected ") + c + (at_ >= text_.size() ? ", but the file ends" : "") +
                 "; copy the set again");
    }

    std::string string() {
        expect('"');
        std::string out;
        while (at_ < text_.size() && text_[at_] != '"') {
            if (static_cast<unsigned char>(text_[at_]) < 0x20) fail("a text has no end; copy the set again");
            if (text_[at_] == '\\') {
                escape(out);
            } else {
                out += text_[at_++];
            }
        }
        expect('"');
        return out;
    }

    double number() {
        (void)peek();
        // from_chars takes no plus sign and no spaces, like JSON; inf and nan are refused by their first letter.
        const char* const begin = text_.data() + at_;
        const char* const end = text_.data() + text_.size();
        double value = 0;
        const bool starts = begin != end && (*begin == '-' || (*begin >= '0' && *begin <= '9'));
        const auto [stopped, error] = std::from_chars(begin, end, value);
        if (!starts || error != std::errc{} || !std::isfinite(value)) fail("expected a number; copy the set again");
        at_ += static_cast<std::size_t>(stopped - begin);
        return value;
    }
    std::uint32_t whole(const char* key, std::uint32_t least, std::uint32_t most) {
        const double value = number();
        if (!(value >= least && value <= most) || std::floor(value) < value)
            fail(std::string(key) + " must be a whole number from " + std::to_string(least) + " to " +
                 std::to_string(most) + "; write the set again");
        return static_cast<std::uint32_t>(value);
    }

    // member(key) reads the value of each, and says false for one that it does not want.
    template <typename Member>
    void object(const Member& member) {
        expect('{');
        if (take('}')) return;
        do {
            const std::string key = string();
            expect(':');
            if (!member(key)) skip(0);
        } while (take(','));
        expect('}');
    }
    template <typename Element>
    void array(const Element& element) {
        expect('[');
        if (take(']')) return;
        do element();
        while (take(','));
        expect(']');
    }
    void end() {
        if (peek() != '\0' || at_ < text_.size()) fail("something follows the set; copy it again");
    }

private:
    void escape(std::string& out) {
        constexpr std::string_view codes = "\"\\/bfnrt", values = "\"\\/\b\f\n\r\t";
        const char code = ++at_ < text_.size() ? text_[at_] : '\0';
        if (const std::size_t which = codes.find(code); code != '\0' && which != std::string_view::npos) {
            out += values[which];
            ++at_;
            return;
        }
        unsigned value = 0;
        const char* const digits = text_.data() + std::min(at_ + 1, text_.size());
        const char* const most = text_.data() + std::min(at_ + 5, text_.size());
        const bool four = code == 'u' && std::from_chars(digits, most, value, 16).ptr == digits + 4;
        if (!four || value == 0 || (value >= 0xd800 && value < 0xe000))
            fail("an escape that a file's name cannot have; write the set again");
        at_ += 5;
        if (value < 0x80) {
            out += static_cast<char>(value);
        } else if (value < 0x800) {
            out += static_cast<char>(0xc0 | value >> 6);
            out += static_cast<char>(0x80 | (value & 0x3f));
        } else {
            out += static_cast<char>(0xe0 | value >> 12);
            out += static_cast<char>(0x80 | (value >> 6 & 0x3f));
            out += static_cast<char>(0x80 | (value & 0x3f));
        }
    }
    void skip(int depth) {
        if (depth > most_depth) fail("values lie too deep in each other; write the set again");
        switch (peek()) {
        case '"': (void)string(); return;
        case '[': return array([&] { skip(depth + 1); });
        case '{':
            return object([&](const std::string&) {
                skip(depth + 1);
                return true;
            });
        default: break;
        }
        for (const std::string_view word : {"true", "false", "null"})
            if (text_.substr(at_, word.size()) == word) {
                at_ += word.size();
                return;
            }
        (void)number();
    }

    const std::string_view text_;
    const std::string& name_;
    std::size_t at_ = 0;
};

bool leads_out(const std::string& file) {
    const std::filesystem::path path = os::path_of(file);
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; }; // messages are one line
    return file.empty() || path.has_root_path() || std::any_of(file.begin(), file.end(), is_control) ||
           std::find(path.begin(), path.end(), "..") != path.end();
}

SetFilePack read_pack(Reader& in) {
    SetFilePack pack;
    int seen = 0;
    constexpr std::uint32_t most = 1u << 20;
    in.object([&](const std::string& key) {
        const auto place = [&](const char* name, std::uint32_t& to, std::uint32_t least, int bit) {
            if (key != name) return false;
            to = in.whole(name, least, most);
            seen |= 1 << bit;
            return true;
        };
        if (key == "file") {
            pack.file = in.string();
            if (leads_out(pack.file))
                in.fail("\"file\" must name a pack in the folder of the set; write the set again");
            seen |= 1;
            return true;
        }
        if (key == "pack_hash") {
            const std::string hash = in.string();
            const auto [end, error] = std::from_chars(hash.data(), hash.data() + hash.size(), pack.pack_hash, 16);
            pack.has_hash = !hash.empty();
            if (pack.has_hash && (error != std::errc{} || hash.size() != 16 || end != hash.data() + hash.size()))
                in.fail("\"pack_hash\" must be 16 hexadecimal digits; write the set again");
            return true;
        }
        return place("tile_x", pack.tile_x, 0, 1) || place("tile_y", pack.tile_y, 0, 2) ||
               place("tiles_x", pack.tiles_x, 1, 3) || place("tiles_y", pack.tiles_y, 1, 4);
    });
    if (seen != 31)
        in.fail("a pack lacks \"file\", \"tile_x\", \"tile_y\", \"tiles_x\" or \"tiles_y\"; write the set again");
    return pack;
}

} // namespace

SetFile parse_set_file(std::string_view text, const std::string& name) {
    Reader in(text, name);
    SetFile set;
    std::uint32_t version = 0;
    bool has_packs = false;
    in.object([&](const std::string& key) {
        if (key == "fjell_set") {
            version = in.whole("\"fjell_set\"", 0, 0xffffffff);
            if (version != set_file_version)
                in.fail("a pack set of version " + std::to_string(version) +
                        "; this build reads version 1: write the set again with it");
        } else if (key == "columns") {
            set.columns = in.whole("\"columns\"", 2, 1u << 20);
        } else if (key == "rows") {
            set.rows = in.whole("\"rows\"", 2, 1u << 20);
        } else if (key == "tile_cells") {
            set.tile_cells = in.whole("\"tile_cells\"", 2, 4096);
        } else if (key == "spacing_m") {
            int count = 0;
            in.array([&] {
                const double value = in.number();
                if (count < 2) set.spacing_m[count] = value;
                ++count;
            });
            if (count != 2) in.fail("\"spacing_m\" must be two numbers; write the set again");
        } else if (key == "packs") {
            has_packs = true;
            in.array([&] {
                if (set.packs.size() == max_set_packs) in.fail("too many packs; make them larger");
                set.packs.push_back(read_pack(in));
            });
        } else {
            return false;
        }
        return true;
    });
    in.end();
    if (version == 0)
        in.fail("this is no pack set (\"fjell_set\" is missing); give a folder that fjell-bake has written");
    if (set.columns == 0 || set.rows == 0 || set.tile_cells == 0 || !(set.spacing_m[0] > 0) || !has_packs)
        in.fail("\"columns\", \"rows\", \"tile_cells\", \"spacing_m\" or \"packs\" is missing; write the set again");
    if (set.packs.empty()) in.fail("the set has no packs; write it again");
    return set;
}

std::string set_file_text(const SetFile& set) {
    const auto number = [](double value) {
        char text[32];
        return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
    };
    std::string out = "{\n  \"fjell_set\": 1,\n  \"columns\": " + std::to_string(set.columns) +
                      ",\n  \"rows\": " + std::to_string(set.rows) +
                      ",\n  \"tile_cells\": " + std::to_string(set.tile_cells) + ",\n  \"spacing_m\": [" +
                      number(set.spacing_m[0]) + ", " + number(set.spacing_m[1]) + "],\n  \"packs\": [";
    for (const SetFilePack& pack : set.packs) {
        out += &pack == &set.packs.front() ? "\n    {\"file\": \"" : ",\n    {\"file\": \"";
        for (const char c : pack.file) {
            if (c == '"' || c == '\\') out += '\\';
            out += c;
        }
        char hash[17] = {};
        for (int i = 0; pack.has_hash && i < 16; ++i) hash[i] = "0123456789abcdef"[pack.pack_hash >> (60 - 4 * i) & 15];
        out += "\", \"tile_x\": " + std::to_string(pack.tile_x) + ", \"tile_y\": " + std::to_string(pack.tile_y) +
               ", \"tiles_x\": " + std::to_string(pack.tiles_x) + ", \"tiles_y\": " + std::to_string(pack.tiles_y) +
               ", \"pack_hash\": \"" + hash + "\"}";
    }
    return out + "\n  ]\n}\n";
}

std::vector<std::string> files_of_pack(const std::string& path) {
    const std::string index = set_file_of(path);
    if (index.empty()) return {path};
    std::vector<std::string> files{index};
    try {
        const std::filesystem::path folder = os::path_of(index).parent_path();
        for (const SetFilePack& pack : parse_set_file(read_text(index), index).packs)
            files.push_back(os::text_of(folder / os::path_of(pack.file)));
    } catch (const Failure&) {
        files.resize(1); // whoever opens it says why
    }
    return files;
}

std::string set_file_of(const std::string& path) {
    std::error_code none;
    const std::filesystem::path place = os::path_of(path), inside = place / "set.json";
    if (std::filesystem::is_directory(place, none))
        return std::filesystem::exists(inside, none) ? os::text_of(inside) : "";
    return path.ends_with(".json") && std::filesystem::is_regular_file(place, none) ? path : "";
}

} // namespace fjell::io
