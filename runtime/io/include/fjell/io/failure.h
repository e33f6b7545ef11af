// The exception of our tools, where it is caught, and how Ctrl-C becomes one.
#pragma once

#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::io {

// One line for stderr that says what to do, and the exit code of the program: 1 if the input is at fault, 2 for wrong
// usage, 3 if the machine is at fault (disk, memory, GPU). Caught once, in main.
struct Failure : std::runtime_error {
    Failure(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
    int exit_code;
};

// Any exception as a Failure. A Failure stays as it is; an exception of the standard library gets a message of ours.
[[nodiscard]] Failure as_failure(const std::exception& thrown);

// Runs the body of a program. An exception becomes one line on stderr, which begins with the program's name, and an
// exit code.
[[nodiscard]] int run_tool(const char* name, const std::function<int()>& body);

// After this call SIGINT, SIGTERM and SIGHUP become a Failure with exit code 130 at the next check_interrupt(). So
// destructors remove files that are half-written.
void catch_interrupts();
void check_interrupt();

} // namespace fjell::io
FJELL_API_END
