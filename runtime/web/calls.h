// What the files of this folder share: calls that JavaScript makes, numbers that it reads and writes, and failures.
//
// JavaScript sees functions with plain arguments. What does not fit into one number goes through `numbers`, an array of
// doubles that both sides know the layout of (package/instance.js). A call that fails throws a JavaScript error out of
// the module; the instance is then not used any more, because nothing was unwound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "fjell/status.h"

#define FJELL_CALL extern "C" __attribute__((used, visibility("default")))

namespace fjell::web {

// A place for what goes in and comes out. 512 numbers.
extern double numbers[512];

// Memory, aligned to 64.
FJELL_CALL void* web_allocate(std::size_t bytes);
FJELL_CALL void web_free(void* memory);

// Throws an Error with this text in JavaScript. argument: whether the caller's arguments are at fault.
[[noreturn]] void fail(const std::string& text);
void require(const Status& status, const char* where);

} // namespace fjell::web
