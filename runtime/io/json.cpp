#include "io/json.h"

#include <algorithm>
#include <iterator>
#include <unordered_set>
#include <vector>

#include "fjell/io/failure.h"

namespace fjell::io {

namespace {

// Walks through a text and keeps nothing but the keys of the objects that are open.
class JsonCheck : public nlohmann::json_sax<nlohmann::json> {
public:
    // Which characters were read so far is the iterator's to know; the parser copies it, so it points here.
    struct Cursor {
        using value_type = char;
        using difference_type = std::ptrdiff_t;
        using pointer = const char*;
        using reference = const char&;
        using iterator_category = std::input_iterator_tag;
        const char** at = nullptr; // null: the end
        const char* end = nullptr;
        reference operator*() const { return **at; }
        Cursor& operator++() {
            ++*at;
            return *this;
        }
        bool operator==(const Cursor& other) const { return done() == other.done(); }
        bool operator!=(const Cursor& other) const { return !(*this == other); }

    private:
        [[nodiscard]] bool done() const { return at == nullptr || *at == end; }
    };

    std::string problem;

    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(number_integer_t) override { return true; }
    bool number_unsigned(number_unsigned_t) override { return true; }
    bool number_float(number_float_t, const string_t&) override { return true; }
    bool string(string_t&) override { return true; }
    bool binary(binary_t&) override { return true; }
    bool start_array(std::size_t) override { return true; }
    bool end_array() override { return true; }
    bool start_object(std::size_t) override {
        keys_.emplace_back();
        return true;
    }
    bool end_object() override {
        keys_.pop_back();
        return true;
    }
    bool key(string_t& name) override {
        if (keys_.back().insert(name).second) return true;
        problem = "\"" + name + "\" is there twice; leave one of them";
        return false;
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& error) override {
        constexpr int number_overflow = 406;
        problem = error.id == number_overflow
                      ? "a number is too large"
                      : "is not JSON; look for a comma, a quote or a bracket that is missing or too many";
        return false;
    }

private:
    std::vector<std::unordered_set<std::string>> keys_;
};

} // namespace

nlohmann::json parse_json(std::string_view text, const std::string& name, JsonComments comments, std::size_t line) {
    const char *at = text.data(), *const end = at + text.size();
    const bool allowed = comments == JsonComments::yes;
    JsonCheck check;
    if (!nlohmann::json::sax_parse(JsonCheck::Cursor{&at, end}, JsonCheck::Cursor{}, &check,
                                   nlohmann::json::input_format_t::json, true, allowed)) {
        for (const char* c = text.data(); c + 1 < at; ++c)
            line += *c == '\n'; // the last one read may be the line's end
        throw Failure(1, name + ":" + std::to_string(line) + ": " + check.problem);
    }
    return nlohmann::json::parse(text, nullptr, true, allowed);
}

namespace {

// Steps over one character, one string or one comment of JSON.
struct JsonWalk {
    std::string_view text;
    std::size_t at = 0, line = 1;

    // What stands here; 0 at the end. Strings as '"', blanks and comments as ' '.
    char step(std::string_view& string) {
        if (at >= text.size()) return 0;
        const char c = text[at];
        const std::size_t begin = at;
        std::size_t end = at + 1;
        if (c == '"') {
            while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
            string = text.substr(begin + 1, std::min(end, text.size()) - begin - 1);
            ++end;
        } else if (text.substr(at, 2) == "//") {
            end = text.find('\n', at);
        } else if (text.substr(at, 2) == "/*") {
            end = text.find("*/", at + 2);
            if (end != std::string_view::npos) end += 2;
        }
        at = std::min(end, text.size());
        line += static_cast<std::size_t>(std::count(text.begin() + static_cast<std::ptrdiff_t>(begin),
                                                    text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
        return c == '/' || c == '\n' || c == '\t' || c == '\r' ? ' ' : c;
    }
};

} // namespace

std::size_t line_of_item(std::string_view text, std::string_view list, std::size_t item) {
    JsonWalk walk{text};
    std::string_view string, key;
    int depth = 0;
    std::size_t number = 0;
    bool inside = false, fresh = false; // in the list; at an item's beginning
    for (;;) {
        const std::size_t line = walk.line;
        const char c = walk.step(string);
        if (c == 0) return 1;
        if (c == ' ') continue;
        if (inside && fresh && c != ']') {
            if (number == item) return line;
            fresh = false;
        }
        if (c == '"' && depth == 1 && !inside) key = string;
        if (c == '[' && depth == 1 && key == list) inside = fresh = true;
        depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
        if (inside && depth == 1) inside = false;
        if (inside && depth == 2 && c == ',') fresh = true, ++number;
    }
}

} // namespace fjell::io
