// The documents against the repository: what a page says that can be looked up is looked up.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/cut.h"
#include "fjell/pack.h"
#include "fjell/profile/keys.h"
#include "fjell/texture.h"
#include "shared/order.h"
#include "shared/record.h"
#include "support/program.h"

using namespace fjell;
using fjell::test::run_in;
using fjell::test::slurp;

namespace {

namespace fs = std::filesystem;
const fs::path root = FJELL_SOURCE_DIR;

// Every file of the repository that is written by hand, by its path from the root.
const std::vector<std::string>& files() {
    static const std::vector<std::string> all = [] {
        std::vector<std::string> found{"README.md",   "CHANGELOG.md",   "CONTRIBUTING.md",
                                       "SECURITY.md", "CMakeLists.txt", "dev"};
        for (const char* folder : {"runtime", "baker", "editor", "content", "profiles", "tests", "docs"})
            for (const auto& entry : fs::recursive_directory_iterator(root / folder))
                if (entry.is_regular_file()) found.push_back(fs::relative(entry.path(), root).string());
        return found;
    }();
    return all;
}

std::vector<std::string> matches(const std::string& text, const std::regex& regex, std::size_t group = 1) {
    std::vector<std::string> found;
    for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at)
        found.push_back((*at)[group].str());
    return found;
}
std::vector<std::string> matches(const std::string& text, const char* pattern) {
    return matches(text, std::regex(pattern));
}

struct Block {            // between ``` fences
    int line = 0;         // of the opening fence
    std::string language; // empty: a command line or a drawing
    std::string source;   // of <!-- from PATH --> in the line above
    std::vector<std::string> lines;
};

struct Page {
    std::string name, text;        // the path from the root
    std::string prose;             // without what stands between ``` fences
    std::vector<std::string> code; // lines between fences, continued ones joined
    std::vector<Block> blocks;
};

Page read_page(const std::string& name) {
    Page page{name, slurp(root / name), {}, {}, {}};
    REQUIRE(!page.text.empty());
    bool fenced = false, continued = false;
    std::istringstream lines(page.text);
    std::string before;
    int number = 0;
    for (std::string line; std::getline(lines, line); before = line) {
        ++number;
        if (fenced && !line.starts_with("```")) page.blocks.back().lines.push_back(line);
        if (line.starts_with("```")) {
            fenced = !fenced;
            if (!fenced) continue;
            const auto from = matches(before, "^<!-- from ([^ ]+) -->$");
            page.blocks.push_back({number, line.substr(3), from.empty() ? "" : from[0], {}});
        } else if (!fenced) {
            page.prose += line + '\n';
        } else {
            const bool more = line.ends_with('\\');
            if (more) line.pop_back();
            if (continued)
                page.code.back() += line;
            else
                page.code.push_back(line);
            continued = more;
        }
    }
    return page;
}

// The change log speaks of what was: only its links must hold.
const std::vector<Page>& pages(bool with_history = false) {
    const auto read = [](bool history) {
        std::vector<Page> found;
        for (const std::string& file : files())
            if (file.ends_with(".md") && (history || file != "CHANGELOG.md")) found.push_back(read_page(file));
        return found;
    };
    static const std::vector<Page> all = read(true), present = read(false);
    return with_history ? all : present;
}

std::vector<std::string> in_backticks(const Page& page) {
    return matches(page.prose, "`([^`\n]+)`");
}

// The words of all sources: identifiers, keys, names of programs.
const std::set<std::string>& words_of_sources() {
    static const std::set<std::string> all = [] {
        std::set<std::string> words;
        for (const std::string& file : files()) {
            if (file.ends_with(".md") || file.ends_with("docs_test.cpp")) continue;
            const std::string extension = fs::path(file).extension().string();
            static const std::set<std::string> texts{".h",    ".c",   ".cpp",   ".txt", ".toml", ".py",
                                                     ".json", ".mjs", ".cmake", ".in",  ""};
            if (texts.count(extension) == 0) continue;
            std::string word;
            for (const char c : slurp(root / file) + ' ') {
                if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
                    word += c;
                } else if (!word.empty()) {
                    words.insert(std::move(word));
                    word.clear();
                }
            }
        }
        return words;
    }();
    return all;
}

// Where a path may start: at the root, at the page, or where includes do.
bool exists(const std::string& path, const Page& page) {
    const std::size_t star = path.find('*');
    const std::string fixed = star == std::string::npos ? path : path.substr(0, path.rfind('/', star));
    for (const fs::path& from :
         {root, (root / page.name).parent_path(), root / "runtime", root / "runtime/include",
          root / "runtime/io/include", root / "runtime/gl/include", root / "runtime/gltf/include",
          root / "runtime/profile/include", root / "runtime/src", root / "build"})
        if (fs::exists(from / fixed)) return true;
    return false;
}

std::string grouped(std::uint64_t number) { // 3,136
    const std::string digits = std::to_string(number);
    std::string text;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i != 0 && (digits.size() - i) % 3 == 0) text += ',';
        text += digits[i];
    }
    return text;
}

// The text literals of our programs and libraries; neighbours are joined, as the compiler joins them.
const std::vector<std::string>& literals() {
    static const std::vector<std::string> all = [] {
        std::vector<std::string> found;
        for (const std::string& file : files()) {
            if (!file.starts_with("runtime/") && !file.starts_with("baker/") && !file.starts_with("editor/")) continue;
            if (!file.ends_with(".cpp") && !file.ends_with(".h")) continue;
            const std::string text = slurp(root / file);
            bool joined = false; // nothing but space since the last literal
            for (std::size_t i = 0; i < text.size(); ++i) {
                if (text.compare(i, 2, "//") == 0) i = std::min(text.find('\n', i), text.size()) - 1;
                if (text[i] != '"') {
                    joined = joined && std::isspace(static_cast<unsigned char>(text[i]));
                    continue;
                }
                if (!joined) found.emplace_back();
                for (++i; i < text.size() && text[i] != '"' && text[i] != '\n'; ++i) {
                    if (text[i] == '\\') ++i;
                    found.back() += text[i];
                }
                joined = true;
            }
        }
        return found;
    }();
    return all;
}

// A message with # for each value: where a literal has {}, and where a page quotes a number or a list of them.
std::string without_values(const std::string& message) {
    const std::string marked = std::regex_replace(message, std::regex(R"(\{[^}]*\}|-?\b[0-9][0-9.]*\b)"), "#");
    return std::regex_replace(marked, std::regex("#(?:, #)+"), "#");
}

// What a program's help lists: --flags and -o.
const std::set<std::string>& flags_of(const std::string& program) {
    static std::map<std::string, std::set<std::string>> known;
    const auto [at, added] = known.try_emplace(program);
    if (added) {
        const auto run = run_in(root, FJELL_BIN_DIR "/" + program + " --help");
        INFO(program << ": " << run.err);
        REQUIRE(run.code == 0);
        for (const std::string& flag : matches(run.out, "(?:^|[\\s,])(--?[a-z][a-z-]*)")) at->second.insert(flag);
        REQUIRE(at->second.count("--help") == 1);
    }
    return at->second;
}

const std::vector<std::string> subcommands{"info",      "verify", "heights", "split",  "join",  "synth",
                                           "materials", "plan",   "shard",   "launch", "merge", "simulate",
                                           "tiles",     "mesh",   "journal", "rebase", "roads", "rivers"};

// "fjell-bake info" of "fjell-bake info PACK --json"; empty when it is no call of one of our programs.
std::string program_of(const std::string& command) {
    std::smatch call;
    if (!std::regex_search(command, call, std::regex("^(?:build/release/bin/)?(fjell-[a-z]+)(?: ([a-z]+))?")))
        return {};
    const std::string sub = call[2].str();
    if (call[1] == "fjell-bake" && std::ranges::find(subcommands, sub) != subcommands.end()) return "fjell-bake " + sub;
    return call[1].str();
}

std::set<std::string> dev_commands() {
    const auto run = run_in(root, "./dev help");
    REQUIRE(run.code == 0);
    const auto listed = matches(run.out, "\\./dev ([a-z]+)");
    return {listed.begin(), listed.end()};
}

// Lines without the indentation that all of them share, and without empty ones at the end.
std::string outdented(const std::vector<std::string>& lines, std::size_t first, std::size_t count) {
    std::size_t shared = std::string::npos;
    for (std::size_t i = first; i < first + count; ++i)
        if (!lines[i].empty()) shared = std::min(shared, lines[i].find_first_not_of(' '));
    std::string text;
    for (std::size_t i = first; i < first + count; ++i)
        text += (lines[i].empty() ? "" : lines[i].substr(shared)) + '\n';
    return text;
}

// Whether these lines follow each other in a file, wherever they are indented to.
bool quotes(const Block& block) {
    std::vector<std::string> lines;
    std::istringstream text(slurp(root / block.source));
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    const std::string wanted = outdented(block.lines, 0, block.lines.size());
    for (std::size_t first = 0; first + block.lines.size() <= lines.size(); ++first)
        if (outdented(lines, first, block.lines.size()) == wanted) return true;
    return false;
}

// Whose files a test builds and runs: tests/door does, or tests/web, but for the last.
const std::vector<std::string> built{"content/hosts/c_loop/",
                                     "content/hosts/first/",
                                     "content/hosts/game/",
                                     "content/hosts/ground/",
                                     "content/hosts/physics/",
                                     "content/hosts/ogre/",
                                     "content/hosts/server/",
                                     "content/hosts/vulkan/",
                                     "content/hosts/web/",
                                     "runtime/session/",
                                     "runtime/include/",
                                     "tests/door/",
                                     "tests/unit/",
                                     "tests/web/"};

} // namespace

TEST_CASE("every block of code in the README and the guides is quoted from a file that a test builds and runs") {
    const std::set<std::string> languages{"c", "cpp", "glsl", "cmake", "js", "html", "sh"};
    int code = 0;
    for (const Page& page : pages()) {
        if (page.name != "README.md" && !page.name.starts_with("docs/guides/")) continue;
        for (const Block& block : page.blocks) {
            INFO(page.name << ':' << block.line << ": " << block.source);
            REQUIRE(!block.lines.empty());
            if (block.language.empty()) { // command lines: another test looks at their flags
                CHECK(block.source.empty());
                for (const std::string& line : block.lines)
                    CHECK(
                        std::regex_search(line, std::regex("^(fjell-[a-z]+ |\\./dev |mkdir -p |npm install |node )")));
                continue;
            }
            if (block.language == "python") { // a page is one program, which tests/python/types_test.py runs
                CHECK((page.name == "docs/guides/python.md" || page.name == "docs/guides/simulators.md"));
                continue;
            }
            CHECK(languages.count(block.language) == 1);
            // Name the source in the line above the block: <!-- from PATH -->
            CHECK(std::ranges::any_of(built,
                                      [&](const std::string& folder) { return block.source.starts_with(folder); }));
            CHECK(quotes(block));
            ++code;
        }
    }
    CHECK(code > 30);
}

TEST_CASE(
    "the first host, with and without a window, is at most 30 lines and 20 names, and the README prints it whole") {
    for (const char* const source : {"main.cpp", "picture.cpp", "embedded.cpp"}) {
        const std::string text = slurp(root / "content/hosts/first" / source);
        CHECK(std::ranges::count(text, '\n') <= 30);
        const auto names = matches(text, "(fjell::[A-Za-z_:]+)");
        CHECK(std::set<std::string>(names.begin(), names.end()).size() <= 20);
        CHECK(names.size() > 8);
    }
    CHECK(slurp(root / "README.md").find("```cpp\n" + slurp(root / "content/hosts/first/main.cpp") + "```") !=
          std::string::npos);
}

TEST_CASE("every link and picture of the documents leads somewhere") {
    for (const Page& page : pages(true))
        for (const std::string& link : matches(page.prose, "\\]\\(([^)\\s]+)\\)")) {
            if (link.starts_with("http")) continue;
            INFO(page.name << ": " << link);
            const std::string path = link.substr(0, link.find('#'));
            const fs::path target = path.empty() ? root / page.name : (root / page.name).parent_path() / path;
            CHECK(fs::exists(target));
            if (path.size() == link.size()) continue;
            std::string headings;
            for (std::string heading : matches(slurp(target), "(?:^|\n)#+ ([^\n]+)")) {
                std::erase_if(heading, [](unsigned char c) { return !std::isalnum(c) && c != ' ' && c != '-'; });
                std::ranges::transform(heading, heading.begin(), [](unsigned char c) {
                    return c == ' ' ? '-' : static_cast<char>(std::tolower(c));
                });
                headings += '#' + heading + '\n';
            }
            CHECK(headings.find(link.substr(path.size()) + '\n') != std::string::npos);
        }
}

TEST_CASE("the index of the documents lists every page, every picture is shown, and the README is short") {
    const std::string index = slurp(root / "docs/README.md");
    for (const Page& page : pages()) {
        if (!page.name.starts_with("docs/") || page.name == "docs/README.md") continue;
        INFO(page.name);
        CHECK(index.find("(" + page.name.substr(5) + ")") != std::string::npos);
    }
    std::string all;
    for (const Page& page : pages()) all += page.prose;
    for (const auto& picture : fs::directory_iterator(root / "docs/pictures")) {
        INFO(picture.path().filename());
        CHECK(all.find("pictures/" + picture.path().filename().string() + ")") != std::string::npos);
    }
    for (const auto& picture : fs::directory_iterator(root / "docs/pictures")) { // docs/pictures.py makes it again
        const std::string name = picture.path().filename().string();
        INFO(name);
        if (picture.path().extension() != ".svg" && name != "experiments-rivals.jpg") // which ./dev experiments draws
            CHECK(std::regex_search(all, std::regex("<!-- makes " + name + "[ \n]")));
    }
    const std::string readme = slurp(root / "README.md");
    CHECK(std::ranges::count(readme, '\n') < 110);
}

TEST_CASE("every path that the documents name exists") {
    std::set<std::string> names;
    for (const std::string& file : files()) names.insert(fs::path(file).filename().string());
    const std::regex rooted("(runtime|baker|editor|content|profiles|tests|docs|fjell|io|gl|gltf|flight|fly)/[^ ]*");
    const std::regex file_name("[a-z0-9_./-]+\\.(h|c|cpp|md|svg|cmake)");
    for (const Page& page : pages()) {
        for (const std::string& token : in_backticks(page)) {
            INFO(page.name << ": " << token);
            if (std::regex_match(token, rooted))
                CHECK(exists(token, page));
            else if (std::regex_match(token, file_name))
                CHECK(names.count(fs::path(token).filename().string()) == 1);
        }
        for (const std::string& line : page.code)
            for (const std::string& path : matches(line, "(?:^|[ \"])((?:content|profiles)/[A-Za-z0-9_./-]+)")) {
                INFO(page.name << ": " << path);
                CHECK(exists(path, page));
            }
    }
    for (const std::string& file : files()) { // rooms in pictures
        if (!file.ends_with(".svg")) continue;
        for (const std::string& room : matches(slurp(root / file), ">((?:runtime|baker|editor)/[a-z/]+)")) {
            INFO(file << ": " << room);
            CHECK(fs::exists(root / room));
        }
    }
}

TEST_CASE("every file that a comment names exists") {
    std::string made; // by the build
    for (const std::string& file : files())
        if (file.ends_with("CMakeLists.txt")) made += slurp(root / file);
    const auto there = [&](const std::string& name) { // some file's path, or its end
        return std::ranges::any_of(files(),
                                   [&](const std::string& file) {
                                       return file.ends_with(name) && (file.size() == name.size() ||
                                                                       file[file.size() - name.size() - 1] == '/');
                                   }) ||
               made.find('/' + name + ')') != std::string::npos;
    };
    const std::regex named("(^|[^A-Za-z0-9_./~<>*-])([a-z][A-Za-z0-9_/-]*\\.(?:h|c|cpp|md|cmake))(?![A-Za-z0-9_.])");
    int comments = 0;
    for (const std::string& file : files()) {
        if (!file.ends_with(".h") && !file.ends_with(".cpp") && !file.ends_with(".c")) continue;
        for (const std::string& comment : matches(slurp(root / file), "//([^\n]*)")) {
            for (const std::string& name : matches(comment, named, 2)) {
                INFO(file << ": //" << comment);
                CHECK(there(name));
                ++comments;
            }
        }
    }
    CHECK(comments > 100);
}

TEST_CASE("every name of the code that the documents use exists in it") {
    const std::set<std::string>& words = words_of_sources();
    const std::regex name(
        "(?:[A-Za-z_]+::)*[a-z0-9]+(?:_[a-z0-9]+)+(?:\\(\\))?|[A-Z][A-Za-z]*(?:::[a-z_]+)?(?:\\(\\))?");
    for (const Page& page : pages())
        for (const std::string& token : in_backticks(page)) {
            if (!std::regex_match(token, name) || std::ranges::all_of(token, [](char c) { return c < 'a'; })) continue;
            const bool forbidden = page.name == "docs/notes/glossary.md" && words.count(token) == 0;
            if (forbidden) continue; // the glossary also names what is not to be said
            INFO(page.name << ": " << token);
            for (const std::string& part : matches(token, "([A-Za-z0-9_]+)")) CHECK(words.count(part) == 1);
        }
    for (const Page& page : pages())
        for (const std::string& key : matches(page.prose, "`((?:refine|budget|stream|view|light|layers)\\.[a-z_]+)`")) {
            INFO(page.name << ": " << key);
            CHECK(fjell::find_profile_key(key) != nullptr);
        }
}

TEST_CASE("every command line of the documents uses flags that its program lists") {
    std::set<std::string> all{"--long", "--times"}; // of ./dev test, of the hosts
    for (const char* program : {"fjell-bake", "fjell-fly", "fjell-editor"}) all.merge(std::set(flags_of(program)));
    for (const std::string& sub : subcommands) all.merge(std::set(flags_of("fjell-bake " + sub)));
    const auto check = [](const Page& page, const std::string& command) {
        const std::string program = program_of(command);
        if (program.empty()) return false;
        if (program == "fjell-lab" && !fs::exists(FJELL_BIN_DIR "/fjell-lab")) {
            WARN("skipped: " << command << ": the lab is built by --long");
            return true;
        }
        const std::string unquoted =
            std::regex_replace(command.substr(0, command.find(" #")), std::regex("\"[^\"]*\""), "");
        for (const std::string& flag : matches(unquoted, " (--?[a-z][a-z-]*)")) {
            INFO(page.name << ": " << command << ": " << flag);
            CHECK(flags_of(program).count(flag) == 1);
        }
        return true;
    };
    int commands = 0;
    for (const Page& page : pages()) {
        for (const std::string& line : page.code) commands += check(page, line);
        for (const std::string& token : in_backticks(page)) {
            if (check(page, token) || page.name.find("notes/") != std::string::npos) continue;
            for (const std::string& flag : matches(token, "^(--[a-z][a-z-]*)")) {
                INFO(page.name << ": " << token);
                CHECK(all.count(flag) == 1);
            }
        }
    }
    CHECK(commands > 40);
}

TEST_CASE("every editor command of the documents is one that the editor lists") {
    const auto run = run_in(root, FJELL_BIN_DIR "/fjell-editor --help-commands");
    REQUIRE(run.code == 0);
    const std::string listed = '\n' + run.out;
    int commands = 0;
    for (const Page& page : pages())
        for (const std::string& verb : matches(page.text, "--do \"?([a-z-]+)")) {
            INFO(page.name << ": " << verb);
            CHECK(std::regex_search(listed, std::regex("\n" + verb + "( |\n)")));
            ++commands;
        }
    CHECK(commands > 5);
}

TEST_CASE("what ./dev help lists is handled and documented, and nothing else is spoken of") {
    const std::set<std::string> listed = dev_commands();
    const std::string script = slurp(root / "dev"), contributing = slurp(root / "CONTRIBUTING.md");
    CHECK(listed.size() > 5);
    for (const std::string& command : listed) {
        INFO(command);
        CHECK(std::regex_search(script, std::regex("\n  " + command + "(\\)| \\|)")));
        CHECK(std::regex_search(contributing, std::regex("\n\\./dev " + command + "\\b")));
    }
    for (const Page& page : pages())
        for (const std::string& command : matches(page.text, "\\./dev ([a-z]+)")) {
            INFO(page.name << ": " << command);
            CHECK(listed.count(command) == 1);
        }
}

TEST_CASE("numbers in the documents are the code's") {
    const std::string format = slurp(root / "docs/pack-format.md"), glossary = slurp(root / "docs/notes/glossary.md"),
                      baking = slurp(root / "docs/guides/baking.md"),
                      bake_help = run_in(root, FJELL_BIN_DIR "/fjell-bake --help").out;
    const auto says = [](const std::string& page, const std::string& text) {
        INFO(text);
        CHECK(page.find(text) != std::string::npos);
    };
    const std::string vertices = grouped(max_page_vertices);
    says(format, "# The pack, version " + std::to_string(pack_version) + "\n");
    says(format, "| " + std::to_string(sizeof(PackHeader)) + " bytes |");
    says(format, "| " + std::to_string(sizeof(ChunkEntry)) + " bytes a chunk|");
    says(format, "(`PageBound`, " + std::to_string(sizeof(PageBound)) + " bytes");
    says(format, "one record of " + std::to_string(sizeof(VertexRecord)) + " bytes a vertex");
    says(format, "| head | " + std::to_string(sizeof(PageHead)) + " |");
    says(format, "| radii | " + std::to_string(page_radii) + ", or 1 a vertex |");
    says(format, "pages of " + vertices + ",");
    says(format, "BC1, " + std::to_string(colour_block_bytes) + " bytes");
    says(format, "BC5, " + std::to_string(normal_block_bytes) + " bytes");
    says(glossary, "one step, " + vertices + " vertices");
    says(glossary, std::to_string(CutBudget{}.segment_triangles) + " by default");
    says(glossary, "a vertex in memory, " + std::to_string(sizeof(VertexRecord)) + " bytes");
    const std::string cut_note = slurp(root / "docs/notes/live-cut.md");
    std::string group_bytes; // of a private struct, which asserts its size
    for (const std::string& file : files())
        if (file.starts_with("runtime/src/"))
            for (const std::string& size :
                 matches(slurp(root / file), "static_assert\\(sizeof\\(GroupState\\) == ([0-9]+)"))
                group_bytes = size;
    says(cut_note, "a cache line of records, with " + group_bytes + " bytes of state");
    const auto memory = matches(bake_help, "whatever the height field's size \\(default ([0-9]+)\\)");
    REQUIRE(memory.size() == 1);
    says(baking, "`--memory` MB (" + memory[0] + " by default)");
}

TEST_CASE("a figure of time stands beside the command that gives it") {
    const std::regex figure("[0-9] (?:ns|us|ms|s)\\b|times (?:faster|slower)|[MG] samples/s|[MG]B/s");
    const std::regex command("`(?:build/release/bin/)?(?:bench_[a-z]+|fjell-[a-z]+|\\./dev)[ `]|[ /]bench_[a-z]+ --|"
                             "\nfjell-[a-z]+ ");
    int figures = 0;
    for (const Page& page : pages()) {
        // A row or a line of the pages that are read for their figures; elsewhere one command for what a heading holds.
        const bool by_line = page.name == "README.md" || page.name == "docs/measured.md";
        if (!by_line && page.name != "docs/promises.md" && page.name != "docs/limits.md" &&
            page.name != "docs/troubleshooting.md" && page.name.find("guides/") == std::string::npos &&
            page.name.find("notes/") == std::string::npos)
            continue;
        std::istringstream lines(by_line ? page.prose : page.text);
        std::string part;
        const auto check = [&] {
            INFO(page.name << ": " << part);
            const bool told = std::regex_search(part, figure);
            figures += told;
            CHECK((!told || std::regex_search(part, command)));
            part.clear();
        };
        for (std::string line; std::getline(lines, line); part += line + '\n')
            if (by_line || line.starts_with('#')) check();
        check();
    }
    CHECK(figures > 20);
    for (const Page& page : pages())
        for (const std::string& bench : matches(page.text, "`(bench_[a-z]+)")) {
            INFO(page.name << ": " << bench);
            CHECK(fs::exists(root / "tests/bench" / (bench + ".cpp")));
        }
}

TEST_CASE("words that the glossary rules out do not occur in the public headers") {
    std::set<std::string> ruled_out;
    for (const std::string& row : matches(slurp(root / "docs/notes/glossary.md"), "\n(\\|[^\n]*\\|)")) {
        const auto cells = matches(row, "\\|([^|]*)");
        REQUIRE(cells.size() >= 3);
        for (const std::string& word : matches(cells[2], "`([^`]+)`")) ruled_out.insert(word);
    }
    CHECK(ruled_out.size() > 10);
    for (const auto& header : fs::directory_iterator(root / "runtime/include/fjell")) {
        const std::string text = slurp(header.path());
        for (const std::string& word : ruled_out) {
            INFO(header.path().filename() << ": " << word);
            CHECK_FALSE(std::regex_search(text, std::regex("\\b" + word + "s?\\b", std::regex::icase)));
        }
    }
}

TEST_CASE("the examples in public headers are quoted from a test that runs them") {
    const std::string run = slurp(root / "tests/unit/header_examples_test.cpp");
    int examples = 0;
    for (const std::string& file : files())
        if (file.starts_with("runtime/") && file.find("/include/") != std::string::npos && file.ends_with(".h"))
            for (const std::string& example :
                 matches(slurp(root / file), "// Example[^\n]*:\n((?://     [^\n]*\n)+)")) {
                ++examples;
                for (const std::string& line : matches(example, "//     ([^\n]*)\n")) {
                    INFO(file << ": " << line);
                    CHECK(run.find("    " + line + "\n") != std::string::npos);
                }
            }
    CHECK(examples >= 10);
}

TEST_CASE("words of our own house do not occur where users read") {
    const std::regex house("\\b(companions?|rivals?|sentinels?|that (?:is|are) none)\\b", std::regex::icase);
    std::map<std::string, std::string> read;
    for (const Page& page : pages())
        if (!page.name.starts_with("docs/notes/") && page.name != "docs/experiments.md" &&
            page.name != "CONTRIBUTING.md")
            read[page.name] = page.prose;
    for (const char* program : {"fjell-bake", "fjell-fly", "fjell-editor"})
        read[program] = run_in(root, std::string(FJELL_BIN_DIR "/") + program + " --help").out;
    for (const std::string& file : files())
        if (file.starts_with("editor/panels/"))
            for (const std::string& text : matches(slurp(root / file), "\"([^\"\n]*)\"")) read[file] += text + "\n";
    CHECK(read.size() > 30);
    for (const auto& [name, text] : read) {
        std::smatch found;
        const bool ours = std::regex_search(text, found, house);
        INFO(name << ": " << found.str());
        CHECK_FALSE(ours);
    }
}

TEST_CASE("the reference lists every public header") {
    const std::string page = slurp(root / "docs/reference/main.md");
    int headers = 0;
    for (const std::string& file : files()) {
        const std::size_t at = file.find("/include/fjell/");
        if (!file.starts_with("runtime/") || at == std::string::npos) continue;
        INFO(file);
        CHECK(page.find(file.substr(at + std::string("/include/").size())) != std::string::npos);
        ++headers;
    }
    CHECK(headers > 40);
}

TEST_CASE("the fields of an export are those that its guide and its header list") {
    const std::string source = slurp(root / "runtime/gltf/snapshot.cpp"),
                      guide = slurp(root / "docs/guides/exporting.md"),
                      header = slurp(root / "runtime/gltf/include/fjell/gltf/snapshot.h");
    const std::size_t first = source.find("Json extras(");
    REQUIRE(first != std::string::npos);
    const auto fields =
        matches(source.substr(first, source.find("return all", first) - first), R"re(\{"([a-z_]+)", )re");
    CHECK(fields.size() > 12);
    for (const std::string& field : fields) {
        INFO(field);
        CHECK(guide.find('`' + field + '`') != std::string::npos);
        CHECK(std::regex_search(header, std::regex("\\b" + field + "\\b")));
    }
}

TEST_CASE("the messages that troubleshooting quotes are those of the sources") {
    std::vector<std::string> ours;
    for (const std::string& literal : literals())
        if (literal.find(' ') != std::string::npos) ours.push_back(without_values(literal));
    const std::string of_others = "error while loading shared libraries: libfjell_runtime"; // the system's
    int messages = 0;
    for (const std::string& seen : matches(slurp(root / "docs/troubleshooting.md"), "\n\\| ([^|\n]*) \\|"))
        for (const std::string& quoted : matches(seen, "`([^`]+)`")) {
            if (quoted.find(' ') == std::string::npos || quoted == of_others) continue;
            const std::string message = without_values(quoted);
            INFO(quoted);
            CHECK(std::ranges::any_of(ours, [&](const std::string& text) {
                // A part of it, or the words in front of what another library says.
                const bool opens = text.size() > 8 && (text.ends_with(": ") || text.ends_with(": #"));
                return text.find(message) != std::string::npos ||
                       (opens && message.starts_with(text.substr(0, text.rfind(' ') + 1)));
            }));
            ++messages;
        }
    CHECK(messages > 15);
}

TEST_CASE("the modes of pictures are listed as the programs name them") {
    std::string names;
    for (const std::string& list :
         matches(slurp(root / "runtime/session/options.h"), "picture_mode_names\\[\\] = \\{([^}]*)\\}"))
        for (const std::string& name : matches(list, "\"([a-z]+)\""))
            names += (names.empty() ? "`" : ", `") + name + '`';
    const std::size_t last = names.rfind(", ");
    REQUIRE(last != std::string::npos);
    names.replace(last, 2, " and ");
    CHECK(slurp(root / "docs/guides/exporting.md").find("The modes are " + names + '.') != std::string::npos);
}

TEST_CASE("every promise names a test that exists") {
    std::string tests;
    for (const std::string& file : files())
        if (file.starts_with("tests/") && file.ends_with(".cpp")) tests += slurp(root / file);
    for (const std::string& file : files()) // Python's names are sentences too
        if (file.starts_with("tests/python/") && file.ends_with(".py"))
            for (std::string name : matches(slurp(root / file), "def test_([a-z0-9_]+)\\(")) {
                std::replace(name.begin(), name.end(), '_', ' ');
                tests += '"' + name + '"';
            }
    tests = std::regex_replace(tests, std::regex("\"\\s*\n\\s*\""), ""); // names over two lines
    const auto promises = matches(slurp(root / "docs/promises.md"), "\n(\\| \\*\\*[^\n]*)");
    CHECK(promises.size() > 10);
    for (const std::string& promise : promises) {
        const auto quoted = matches(promise, "\\| \"([^\"]+)\" \\|");
        INFO(promise);
        REQUIRE(quoted.size() == 1);
        CHECK(tests.find("\"" + quoted[0] + "\"") != std::string::npos);
    }
}

TEST_CASE("the capacity table is what the constants of its page make of it") {
    const std::string page = slurp(root / "docs/limits.md");
    const auto number = [](std::string text) {
        std::erase(text, ',');
        return std::stod(text);
    };
    const auto constant = [&](const std::string& name) {
        const auto found = matches(page, std::regex("\\n\\| `" + name + "`[^|]*\\| ([0-9.,]+) \\|"));
        INFO(name);
        REQUIRE(found.size() == 1);
        return number(found[0]);
    };
    const double rate = constant("rate"), disk = constant("disk"), pack = constant("pack"), hour_s = 3600, gb = 1e9;
    const double ten_machines = rate * constant("cores") * constant("used");
    int rows = 0;
    for (const std::string& row : matches(page, "\n(\\| [0-9][^\n]*)")) {
        std::vector<double> cells;
        for (const std::string& cell : matches(row, "([0-9.,]+)")) cells.push_back(number(cell));
        INFO(row);
        REQUIRE(cells.size() == 7);
        const double n = cells[0] * gb / 2; // samples of two bytes
        const double shards_s = std::max(constant("border") * n / ten_machines, constant("traffic") * n / disk);
        const double merge_s = n / 256 / rate + 2 * pack * n / disk;
        const double right[] = {cells[0],
                                std::sqrt(n),
                                n / rate / hour_s,
                                (shards_s + merge_s) / hour_s,
                                constant("work") * n / gb,
                                pack * n / gb,
                                (constant("memory") + constant("directory") * n) / gb};
        for (std::size_t i = 0; i < cells.size(); ++i) // two digits are shown
            CHECK(std::abs(cells[i] - right[i]) <= 0.05 * right[i]);
        ++rows;
    }
    CHECK(rows == 4);
}
