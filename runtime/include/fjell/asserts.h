// What happens when an assert of the library fails.
//
// Asserts find faults of the library itself. Faults of a host or a file are answered with a Status instead. Only the
// CMake option FJELL_VALIDATE compiles asserts, for tests. A failed assert then prints one line on stderr and aborts
// the process, because the state is not usable any more.
//
// The handler belongs to the process, not to an object, because an assert may fail where no object is known. Thread:
// set the handler before other threads use the library; it is called on the thread that fails. Allocates nothing,
// throws nothing.
#pragma once

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// A handler for the host's own log and crash report, called in place of the line on stderr. condition: what should have
// been true, or the fault that a check found. The process aborts when the handler returns. It must not throw, and must
// not call the library.
using AssertHandler = void (*)(const char* condition, const char* file, int line);

// Sets the handler; nullptr restores the line on stderr. False: this library was compiled without asserts, and never
// calls a handler.
bool set_assert_handler(AssertHandler handler);

} // namespace fjell
FJELL_API_END
