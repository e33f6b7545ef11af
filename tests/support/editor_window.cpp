#include "support/editor_window.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <map>
#include <span>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/program.h"

namespace fjell::test {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr auto lost_after = 30s;
constexpr auto longest_wait = 180s; // with both cores busy a frame may take a second, and a script a minute

// Between two looks at something outside this process.
void pause_polling() {
    std::this_thread::sleep_for(2ms);
}

bool exists(const char* program) {
    return std::system((std::string("command -v ") + program + " >/dev/null 2>&1").c_str()) == 0;
}

pid_t start(const std::vector<std::string>& words, const std::function<void()>& in_child) {
    std::vector<char*> pointers;
    for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
    pointers.push_back(nullptr);
    const pid_t pid = fork();
    if (pid == 0) {
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL); // a test that is killed leaves nothing running
        std::signal(SIGPIPE, SIG_DFL);
        in_child();
        execvp(pointers[0], pointers.data());
        _exit(127);
    }
    return pid;
}

void open_as(int fd, const std::string& path) {
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(file, fd);
}

} // namespace

std::string why_no_windows() {
    for (const char* program : {"Xvfb", "xdotool"})
        if (!exists(program)) return std::string(program) + " is not installed";
    return {};
}

VirtualDisplay::VirtualDisplay(std::uint32_t width, std::uint32_t height) {
    int pipe_fds[2];
    if (pipe(pipe_fds) != 0) throw std::runtime_error("no pipe");
    const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
    pid_ = start({"Xvfb", "-displayfd", std::to_string(pipe_fds[1]), "-screen", "0", screen, "-fbdir", folder_.path,
                  "-nolisten", "tcp", "-noreset", "-r"} /* no keys repeat, however slow the machine is */,
                 [&] {
                     close(pipe_fds[0]);
                     open_as(2, folder_ / "log");
                 });
    close(pipe_fds[1]);
    char number[16] = {};
    std::size_t length = 0;
    while (length + 1 < sizeof number && read(pipe_fds[0], number + length, 1) == 1 && number[length] != '\n') ++length;
    close(pipe_fds[0]);
    number[length] = 0;
    if (length == 0) throw std::runtime_error("Xvfb did not start: " + slurp(folder_ / "log"));
    name_ = std::string(":") + number;
}

VirtualDisplay::~VirtualDisplay() {
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
}

// X window dump, version 7: big-endian words, then the colour map, then rows of 32-bit pixels.
gl::Image VirtualDisplay::picture() const {
    const std::string dump = slurp(folder_ / "Xvfb_screen0");
    const auto word = [&](std::size_t i) {
        std::uint32_t value = 0;
        for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<std::uint8_t>(dump.at(4 * i + k));
        return value;
    };
    const std::size_t header = word(0), width = word(4), height = word(5), row = word(12), colours = word(19);
    REQUIRE(word(11) == 32);
    const bool little = word(7) == 0;
    gl::Image image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
    image.rgb.resize(3 * width * height);
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                image.rgb[3 * (y * width + x) + c] = static_cast<std::uint8_t>(
                    dump.at(header + 12 * colours + y * row + 4 * x + (little ? 2 - c : c + 1)));
    return image;
}

Place view_of(const nlohmann::json& state) {
    const nlohmann::json& v = state["interface"]["view_px"];
    return {v[0], v[1], v[2], v[3]};
}

double changed(const gl::Image& a, const gl::Image& b, const Place& p) {
    std::size_t differ = 0, all = 0;
    for (auto y = static_cast<std::uint32_t>(p.y); y < static_cast<std::uint32_t>(p.y + p.height); ++y)
        for (auto x = static_cast<std::uint32_t>(p.x); x < static_cast<std::uint32_t>(p.x + p.width); ++x, ++all) {
            const std::uint8_t *c = a.pixel(x, y), *d = b.pixel(x, y);
            differ += std::abs(c[0] - d[0]) + std::abs(c[1] - d[1]) + std::abs(c[2] - d[2]) > 24;
        }
    return static_cast<double>(differ) / static_cast<double>(all);
}

EditorWindow::EditorWindow(const VirtualDisplay& display, const fs::path& home,
                           const std::vector<std::string>& arguments, Pixels pixels)
    : display_(display), home_(home) {
    std::vector<std::string> words{FJELL_BIN_DIR "/fjell-editor"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    pid_ = start(words, [&] {
        setenv("DISPLAY", display_.name().c_str(), 1);
        setenv("HOME", home_.c_str(), 1);
        for (const char* folder : {"XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"}) unsetenv(folder);
        if (pixels == Pixels::unseen) setenv("LP_NO_RAST", "1", 1); // as no_pixels (program.h)
        setenv("FJELL_EDITOR_DUMP", (home_ / "state.json").c_str(), 1);
        open_as(1, home_ / "out");
        open_as(2, home_ / "err");
    });
    start_tool();
    find();
}

void EditorWindow::start_tool() {
    std::signal(SIGPIPE, SIG_IGN); // where it has ended
    int to_tool[2], from_tool[2];
    if (pipe2(to_tool, O_CLOEXEC) != 0 || pipe2(from_tool, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    tool_ = start({"xdotool", "-"}, [&] {
        setenv("DISPLAY", display_.name().c_str(), 1);
        dup2(to_tool[0], 0);
        dup2(from_tool[1], 1);
        open_as(2, home_ / "xdotool.err");
    });
    close(to_tool[0]);
    close(from_tool[1]);
    tool_in_ = to_tool[1];
    tool_out_ = from_tool[0];
}

void EditorWindow::end_tool() {
    close(tool_in_); // which ends it
    close(tool_out_);
    waitpid(tool_, nullptr, 0);
}

void EditorWindow::find() {
    window_.clear();
    const auto start_time = Clock::now();
    while (window_.empty() && Clock::now() - start_time < longest_wait && runs()) {
        const std::string found = xdotool("search --onlyvisible --name Fjell");
        window_ = found.substr(0, found.find('\n'));
        if (window_.empty()) pause_polling();
    }
    INFO(errors());
    REQUIRE(!window_.empty());
    xdotool("windowmove " + window_ + " 0 0");
    until("the focus", [&](const nlohmann::json& s) {
        const bool focused = s["input"]["focused"];
        if (!focused) xdotool("windowfocus " + window_);
        return focused;
    });
}

EditorWindow::~EditorWindow() {
    if (runs()) {
        kill(pid_, SIGKILL);
        waitpid(pid_, &status_, 0);
    }
    end_tool();
}

bool EditorWindow::runs() {
    if (pid_ < 0) return false;
    const pid_t ended = waitpid(pid_, &status_, WNOHANG);
    if (ended == pid_) pid_ = -1;
    return ended == 0;
}

int EditorWindow::exit_code() {
    const auto start_time = Clock::now();
    while (runs() && Clock::now() - start_time < longest_wait) pause_polling();
    if (std::optional<nlohmann::json> now = dump()) {
        now->erase("marks");
        FAIL("the editor did not end; it is\n" << now->dump(1));
    }
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

std::string EditorWindow::errors() const {
    return slurp(home_ / "err");
}

void EditorWindow::signal(int number) {
    kill(pid_, number);
}

// One xdotool for all that a window is told: it takes a command a line. What a command has printed ends where the
// pointer's place does, which is asked for after each. A window that goes while it is looked for ends it.
std::string EditorWindow::xdotool(const std::string& what) {
    const std::string lines = what + "\ngetmouselocation\n";
    std::string printed, line;
    const bool told = write(tool_in_, lines.data(), lines.size()) == static_cast<ssize_t>(lines.size());
    for (char c = 0; told && read(tool_out_, &c, 1) == 1;) {
        line += c;
        if (c != '\n') continue;
        if (line.starts_with("x:")) return printed;
        printed += std::exchange(line, {});
    }
    end_tool();
    start_tool();
    return {};
}

// The request is remembered by the editor, so one signal is enough.
std::optional<nlohmann::json> EditorWindow::dump() {
    const fs::path file = home_ / "state.json";
    fs::remove(file);
    if (!runs()) return {};
    kill(pid_, SIGUSR1);
    const auto start_time = Clock::now();
    while (!fs::exists(file)) { // renamed into place, so it is whole
        if (!runs()) return {};
        if (Clock::now() - start_time > longest_wait) FAIL("the editor does not answer: " + errors());
        pause_polling();
    }
    nlohmann::json state = nlohmann::json::parse(slurp(file));
    frame_ = state["frame"];
    input_ = state["input"];
    return state;
}

nlohmann::json EditorWindow::state() {
    std::optional<nlohmann::json> now = dump();
    if (!now) FAIL("the editor has ended: " + errors());
    return *now;
}

std::optional<nlohmann::json> EditorWindow::until_or_end(const std::string& what, const Condition& holds) {
    const auto start_time = Clock::now();
    for (;;) {
        std::optional<nlohmann::json> now = dump();
        if (!now || holds(*now)) return now;
        if (Clock::now() - start_time > longest_wait) {
            now->erase("marks");
            FAIL("waited for: " << what << "; it is\n" << now->dump(1));
        }
    }
}

nlohmann::json EditorWindow::until(const std::string& what, const Condition& holds) {
    std::optional<nlohmann::json> now = until_or_end(what, holds);
    if (!now) FAIL("the editor has ended; waited for: " << what << "; " << errors());
    return *now;
}

// A dialog is laid out in its first frame and put in its place in the second.
Place EditorWindow::place(const std::string& mark) {
    nlohmann::json before;
    until("a control " + mark + " at rest", [&](const nlohmann::json& s) {
        const nlohmann::json now = s["marks"].contains(mark) ? s["marks"][mark] : nlohmann::json();
        const bool rests = !now.is_null() && now == before;
        before = now;
        return rests;
    });
    return {before[0], before[1], before[2], before[3]};
}

void EditorWindow::settle() {
    const std::uint64_t seen = frame_;
    (void)until_or_end("two frames", [&](const nlohmann::json& s) { return s["frame"] >= seen + 2; });
}

// Counts from the last dump: every event before was waited for.
void EditorWindow::send_unsettled(const std::string& what, const char* counter, std::uint64_t events) {
    const std::uint64_t before = input_[counter], first_frame = frame_;
    xdotool(what);
    const auto sent = Clock::now();
    // Once in some ten thousand keys a press and its release come to no window, on a starved machine. Nobody knows
    // where they stay: the editor counts all that GLFW has. So a key is sent again, but once in a test program, or an
    // editor that loses keys would pass.
    static bool sent_again = false;
    (void)until_or_end(what + " to be seen", [&](const nlohmann::json& s) {
        const std::uint64_t came = s["input"][counter].get<std::uint64_t>() - before;
        const bool seen = came >= events;
        if (!seen && !sent_again && what.starts_with("key ") && Clock::now() - sent > lost_after &&
            s["frame"] > first_frame + 20) {
            sent_again = true;
            WARN(what << ": " << came << " of " << events << " events came; sent again");
            xdotool(what);
        }
        return seen;
    });
}

void EditorWindow::send(const std::string& what, const char* counter, std::uint64_t events) {
    send_unsettled(what, counter, events);
    settle();
}

void EditorWindow::between_frames(const std::vector<std::string>& what, const char* counter, std::uint64_t events) {
    const std::uint64_t before = input_[counter];
    signal(SIGSTOP);
    for (const std::string& words : what) xdotool(words);
    signal(SIGCONT);
    (void)until_or_end("what was done between two frames",
                       [&](const nlohmann::json& s) { return s["input"][counter] >= before + events; });
    settle();
}

void EditorWindow::move(double x, double y) {
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const std::string what = "mousemove " + std::to_string(column) + " " + std::to_string(row);
    xdotool(what);
    until(what + " to be seen", [&](const nlohmann::json& s) {
        return s["input"]["pointer_px"] == nlohmann::json{column, row};
    });
    settle();
}

void EditorWindow::click_at(double x, double y) {
    move(x, y);
    send("mousedown 1", "buttons", 1);
    send("mouseup 1", "buttons", 1);
}

void EditorWindow::click(const std::string& mark) {
    const Place p = place(mark);
    click_at(p.x + p.width / 2, p.y + p.height / 2);
}

void EditorWindow::click_twice(const std::string& mark) {
    const Place p = place(mark);
    move(p.x + p.width / 2, p.y + p.height / 2);
    send("click --repeat 2 --delay 1 1", "buttons", 4);
}

void EditorWindow::drag_at(double x, double y, double to_x, double to_y) {
    move(x, y);
    send("mousedown 1", "buttons", 1);
    constexpr int steps = 4;
    for (int i = 1; i <= steps; ++i) move(x + (to_x - x) * i / steps, y + (to_y - y) * i / steps);
    send("mouseup 1", "buttons", 1);
}

void EditorWindow::drag(const std::string& mark, double from, double to) {
    const Place p = place(mark);
    const double y = p.y + p.height / 2;
    drag_at(p.x + from * p.width, y, p.x + to * p.width, y);
}

void EditorWindow::key(const std::string& name) {
    const auto keys = static_cast<std::uint64_t>(std::ranges::count(name, '+')) + 1; // with its modifiers
    send("key " + name, "keys", 2 * keys);
}

nlohmann::json EditorWindow::hold(const std::string& name, const std::string& what, const Condition& holds) {
    send("keydown " + name, "keys", 1);
    nlohmann::json reached = until(what, holds);
    send("keyup " + name, "keys", 1);
    return reached;
}

void EditorWindow::go_to(const std::string& mark, const std::string& by) {
    std::string passed;
    for (int i = 0; i < 120; ++i) {
        const std::string at = state()["interface"]["focus"];
        if (at == mark) return;
        passed += " " + (at.empty() ? "-" : at);
        key(by);
    }
    FAIL(by << " does not come to " << mark << ", but to" << passed);
}

// Some different letters at once: the same one twice within some milliseconds is a repeat to GLFW, and the editor
// remembers 16 presses between two frames. What takes Shift goes alone.
void EditorWindow::type(const std::string& text) {
    static const std::map<char, std::string> names{
        {'.', "period"}, {'/', "slash"}, {'-', "minus"}, {'_', "underscore"}};
    constexpr std::size_t at_once = 12;
    const auto shifted = [](char c) { return c == '_' || (c >= 'A' && c <= 'Z'); };
    for (std::size_t from = 0; from < text.size();) {
        std::size_t count = 1;
        while (!shifted(text[from]) && count < at_once && from + count < text.size() && !shifted(text[from + count]) &&
               text.find(text[from + count], from) == from + count)
            ++count;
        const std::string letters = text.substr(from, count);
        std::string keys;
        for (const char c : letters) {
            const auto named = names.find(c);
            keys += ' ' + (named == names.end() ? std::string(1, c) : named->second);
        }
        const std::uint64_t before = input_["characters"];
        send_unsettled("key --delay 2" + keys, "keys", shifted(text[from]) ? 4 : 2 * count);
        until("the characters " + letters,
              [&](const nlohmann::json& s) { return s["input"]["characters"] >= before + count; });
        from += count;
    }
    settle();
}

void EditorWindow::wheel(int notches) {
    const int count = std::abs(notches);
    send("click --repeat " + std::to_string(count) + " --delay 1 " + (notches > 0 ? "4" : "5"), "scrolls",
         static_cast<std::uint64_t>(count));
}

void EditorWindow::resize(std::uint32_t width, std::uint32_t height) {
    xdotool("windowsize " + window_ + " " + std::to_string(width) + " " + std::to_string(height));
    until("the new size", [&](const nlohmann::json& s) {
        return s["interface"]["window_px"] == nlohmann::json{width, height};
    });
    settle();
}

} // namespace fjell::test
