// The one exception tools may throw, where it ends, and how Ctrl-C becomes one.
#pragma once

#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::io {

// One line for stderr, with the remedy in it, and the program's exit code: 1 the input is at fault, 2 usage, 3 the
// machine (disk, memory, GPU) is. Caught once, in main.
struct Failure : std::runtime_error {
    Failure(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
    int exit_code;
};

// What was thrown, as one: a Failure as it is, what the standard library throws in our words.
[[nodiscard]] Failure as_failure(const std::exception& thrown);

// Runs a program's body at the edge: whatever it throws becomes one line on stderr, headed by the program's name, and
// an exit code.
[[nodiscard]] int run_tool(const char* name, const std::function<int()>& body);

// From here on SIGINT, SIGTERM and SIGHUP become a Failure with exit code 130 at the next check_interrupt(), so that
// destructors remove what is half-written.
void catch_interrupts();
void check_interrupt();

} // namespace fjell::io
FJELL_API_END
