// Asserts: what must hold inside the library, whatever a host passes, and would go wrong in silence if it did not.
// Compiled to nothing, unless the CMake option FJELL_VALIDATE is on; then the first one that fails goes to the host's
// handler (fjell/asserts.h), or is named on stderr, and the process aborts. They are no error handling: what a host, a
// file or a thread can cause gets a status.
#pragma once

#include "fjell/asserts.h"
#include "shared/compiler.h"

namespace fjell {

[[noreturn]] FJELL_COLD void fail_assert(const char* file, int line, const char* condition);

} // namespace fjell

#ifdef FJELL_VALIDATE
#define FJELL_ASSERT(condition)                                                                                        \
    ((condition) ? static_cast<void>(0) : ::fjell::fail_assert(__FILE__, __LINE__, #condition))
#else
#define FJELL_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0)) // compiles, and is not evaluated
#endif
