// What happens when an assert of the library fails.
//
// Asserts look for faults of the library itself, never for those of a host or a file, which are answered with a Status.
// They are compiled in with the CMake option FJELL_VALIDATE alone, for tests. Then a failure prints one line on stderr
// and aborts the process, because a state that is not what it must be cannot be used on.
//
// Of the process, not of an object: a failure may lie anywhere, also where no object is at hand. Thread: set the
// handler before others use the library; it is called on the thread that fails. Allocates nothing, throws nothing.
#pragma once

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// condition: what should have held, or what a walk found. For a host's own log and crash report, in place of the line
// on stderr. The process aborts when it returns. It must not throw, nor call the library.
using AssertHandler = void (*)(const char* condition, const char* file, int line);

// nullptr: the line on stderr again. False: this library is compiled without asserts, and never calls it.
bool set_assert_handler(AssertHandler handler);

} // namespace fjell
FJELL_API_END
