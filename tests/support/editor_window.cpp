#include "support/editor_window.h"

#include <catch2/catch.hpp>

#include <bit>
#include <chrono>
#include <csignal>
#include <cstring>
#include <span>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/program.h"

namespace fjell::test {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr auto patience = 30s;

void rest(std::chrono::milliseconds time = 30ms) {
    std::this_thread::sleep_for(time);
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
                  "-nolisten", "tcp", "-noreset"},
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

EditorWindow::EditorWindow(const VirtualDisplay& display, const fs::path& home,
                           const std::vector<std::string>& arguments)
    : display_(display), home_(home) {
    std::vector<std::string> words{FJELL_BIN_DIR "/fjell-editor"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    pid_ = start(words, [&] {
        setenv("DISPLAY", display_.name().c_str(), 1);
        setenv("HOME", home_.c_str(), 1);
        for (const char* folder : {"XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"}) unsetenv(folder);
        setenv("FJELL_EDITOR_DUMP", (home_ / "state.json").c_str(), 1);
        open_as(1, home_ / "out");
        open_as(2, home_ / "err");
    });
    find();
}

void EditorWindow::find() {
    window_.clear();
    const auto start_time = Clock::now();
    while (window_.empty() && Clock::now() - start_time < patience && runs()) {
        rest(100ms);
        const Run found = run_in("/", "DISPLAY=" + display_.name() + " xdotool search --onlyvisible --name Fjell");
        window_ = found.out.substr(0, found.out.find('\n'));
    }
    INFO(errors());
    REQUIRE(!window_.empty());
    rest(300ms);
    xdotool("windowmove " + window_ + " 0 0 windowfocus " + window_);
}

EditorWindow::~EditorWindow() {
    if (runs()) {
        kill(pid_, SIGKILL);
        waitpid(pid_, &status_, 0);
    }
}

bool EditorWindow::runs() {
    if (pid_ < 0) return false;
    const pid_t ended = waitpid(pid_, &status_, WNOHANG);
    if (ended == pid_) pid_ = -1;
    return ended == 0;
}

int EditorWindow::exit_code() {
    const auto start_time = Clock::now();
    while (runs() && Clock::now() - start_time < patience) rest();
    INFO("the editor did not end");
    REQUIRE(pid_ < 0);
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

std::string EditorWindow::errors() const {
    return slurp(home_ / "err");
}

void EditorWindow::signal(int number) {
    kill(pid_, number);
}

void EditorWindow::xdotool(const std::string& what) {
    const Run run = run_in("/", "DISPLAY=" + display_.name() + " xdotool " + what);
    INFO("xdotool " << what << ": " << run.err);
    REQUIRE(run.code == 0);
}

nlohmann::json EditorWindow::state() {
    const fs::path file = home_ / "state.json";
    fs::remove(file);
    const auto start_time = Clock::now();
    while (!fs::exists(file)) { // renamed into place, so it is whole
        if (!runs() || Clock::now() - start_time > patience) FAIL("the editor does not answer: " + errors());
        kill(pid_, SIGUSR1);
        for (int i = 0; i < 20 && !fs::exists(file); ++i) rest(10ms);
    }
    return nlohmann::json::parse(slurp(file));
}

nlohmann::json EditorWindow::until(const std::string& what, const std::function<bool(const nlohmann::json&)>& holds) {
    const auto start_time = Clock::now();
    for (;;) {
        nlohmann::json now = state();
        if (holds(now)) return now;
        if (Clock::now() - start_time > patience) {
            now.erase("marks");
            FAIL("waited for: " << what << "; it is\n" << now.dump(1));
        }
        rest(50ms);
    }
}

Place EditorWindow::place(const std::string& mark) {
    const nlohmann::json found =
        until("a control " + mark, [&](const nlohmann::json& s) { return s["marks"].contains(mark); })["marks"][mark];
    return {found[0], found[1], found[2], found[3]};
}

void EditorWindow::move(double x, double y) {
    xdotool("mousemove " + std::to_string(static_cast<int>(x)) + " " + std::to_string(static_cast<int>(y)));
    rest(150ms); // a frame or two, so that the control under the pointer knows it
}

void EditorWindow::click_at(double x, double y) {
    move(x, y);
    xdotool("mousedown 1");
    rest(150ms);
    xdotool("mouseup 1");
    rest(150ms);
}

void EditorWindow::click(const std::string& mark) {
    const Place p = place(mark);
    click_at(p.x + p.width / 2, p.y + p.height / 2);
}

void EditorWindow::drag_at(double x, double y, double to_x, double to_y) {
    move(x, y);
    xdotool("mousedown 1");
    rest(150ms);
    constexpr int steps = 8;
    for (int i = 1; i <= steps; ++i) move(x + (to_x - x) * i / steps, y + (to_y - y) * i / steps);
    xdotool("mouseup 1");
    rest(150ms);
}

void EditorWindow::drag(const std::string& mark, double from, double to) {
    const Place p = place(mark);
    const double y = p.y + p.height / 2;
    drag_at(p.x + from * p.width, y, p.x + to * p.width, y);
}

void EditorWindow::key(const std::string& name) {
    xdotool("key " + name);
    rest(150ms);
}

void EditorWindow::hold(const std::string& name, double seconds) {
    xdotool("keydown " + name);
    rest(std::chrono::milliseconds(static_cast<int>(1000 * seconds)));
    xdotool("keyup " + name);
    rest(150ms);
}

void EditorWindow::type(const std::string& text) {
    xdotool("type --delay 60 -- '" + text + "'");
    rest(150ms);
}

void EditorWindow::wheel(int notches) {
    for (int i = 0; i < std::abs(notches); ++i) {
        xdotool(std::string("click ") + (notches > 0 ? "4" : "5"));
        rest(100ms);
    }
}

void EditorWindow::resize(std::uint32_t width, std::uint32_t height) {
    xdotool("windowsize " + window_ + " " + std::to_string(width) + " " + std::to_string(height));
    rest(300ms);
}

} // namespace fjell::test
