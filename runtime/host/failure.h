// The one exception tools may throw.
#pragma once

#include <stdexcept>
#include <string>

namespace fjell::host {

// One line for stderr, with the remedy in it, and the program's exit code: 1 the input is at fault, 2 usage, 3 the
// machine (disk, memory, GPU) is. Caught once, in main.
struct Failure : std::runtime_error {
    Failure(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
    int exit_code;
};

} // namespace fjell::host
