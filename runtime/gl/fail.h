// How everything in runtime/gl fails. Internal to it.
#pragma once

#include <string>

#include "fjell/io/failure.h"

namespace fjell::gl {

// what: one line with the number to change. code: as Failure's.
[[noreturn]] inline void fail(const std::string& what, int code = 3) {
    throw io::Failure(code, what);
}

} // namespace fjell::gl
