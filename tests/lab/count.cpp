#include "lab/count.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "lab/rivals.h"

extern char** environ;

namespace fjell::lab {

// The name that callgrind is told; in no namespace, and reached through a pointer, so that it stays a function.
extern "C" void fjell_lab_counted_refine(rivals::Rival& rival, const View& view, double error_px);
extern "C" [[gnu::noinline]] void fjell_lab_counted_refine(rivals::Rival& rival, const View& view, double error_px) {
    (void)rival.refine(view, error_px, rivals::unlimited_operations);
}

namespace {

// Its exit code; none: there is no such program.
std::optional<int> run_child(const std::vector<std::string>& command) {
    std::vector<char*> arguments;
    for (const std::string& each : command) arguments.push_back(const_cast<char*>(each.c_str()));
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int error = posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ);
    if (error == ENOENT) return std::nullopt;
    if (error != 0) throw io::Failure(3, fmt::format("{}: cannot be started: {}", command[0], std::strerror(error)));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    io::check_interrupt();
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

} // namespace

std::optional<double> instructions_a_frame(const Counting& counting, const Recipe& recipe, std::size_t number,
                                           std::size_t frames) {
    static bool cannot = false;
    if (cannot) return std::nullopt;
    const auto leave_out = [](std::string_view why) {
        cannot = true;
        fmt::print(stderr, "fjell-lab: instructions are not counted: {}\n", why);
        return std::nullopt;
    };
    std::vector<std::string> command{"valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
                                     "--toggle-collect=fjell_lab_counted_refine", "--log-file=" + counting.log};
    command.insert(command.end(), counting.command.begin(), counting.command.end());
    command.insert(command.end(), {"--count", fmt::format("{}:{}", recipe.name, number)});
    const std::optional<int> code = run_child(command);
    if (!code) return leave_out("valgrind is not installed; install it, and run with --fresh");
    // As valgrind ends where it meets an instruction that it does not know, in a library's start already.
    if (*code == 128 + SIGILL)
        return leave_out(fmt::format("valgrind does not know all instructions of this processor ({}); count on another "
                                     "machine, with --fresh",
                                     counting.log));
    const std::string log = io::read_text(counting.log), key = "Collected : ";
    const std::size_t at = log.find(key);
    if (*code != 0 || at == std::string::npos)
        throw io::Failure(1, fmt::format("{}: counting instructions failed (exit code {}); {} says why", recipe.file,
                                         *code, counting.log));
    return std::strtod(log.c_str() + at + key.size(), nullptr) / static_cast<double>(frames);
}

void fly_counted(const Recipe& recipe, const Case& c, World& world) {
    rivals::Rival& rival = *world.bout(c, recipe.tile_cells[0]).rival;
    const std::vector<View> views = world.views(c, recipe.frames);
    settle(rival, views[0], c.error_px);
    void (*volatile const refine)(rivals::Rival&, const View&, double) = fjell_lab_counted_refine;
    for (const View& view : views) refine(rival, view, c.error_px);
}

} // namespace fjell::lab
