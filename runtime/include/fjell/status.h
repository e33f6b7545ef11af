// What a call returns: a code, the field or place at fault, and a table of messages that say what to do.
//
// Ownership: `field` always points to a string with static lifetime. Thread: any. Allocates nothing, throws nothing.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

// What went wrong.
enum class StatusCode : std::uint8_t {
    ok,
    truncated,          // the bytes end before the pack does
    not_a_pack,         // the magic number is missing
    wrong_version,      // written by another version of the baker
    wrong_layout,       // same version, another record layout or byte order
    corrupt,            // a checksum or a cross-check fails
    out_of_range,       // a number lies outside what the format or the call allows
    memory_too_small,   // the host's memory is smaller than the matching *_bytes() function says
    budget_too_small,   // a capacity cannot even hold the coarsest mesh
    out_of_slots,       // every page slot is taken
    coarser_page_first, // pages are loaded from coarse to fine
    not_supported,      // this kind of pack does not work with the method
    unreadable,         // the client could not read the bytes
    invalid_handle,     // an empty handle, or its object has been destroyed
    wrong_pack,         // not the pack that the terrain was made from
    wrong_terrain       // the cut is of another terrain
};

// The result of a call.
struct [[nodiscard]] Status {
    StatusCode code = StatusCode::ok;
    const char* field = ""; // the field, argument or section at fault; static lifetime

    [[nodiscard]] constexpr bool ok() const { return code == StatusCode::ok; }
};

// The message of a code: one line that says what happened and what to do. Static lifetime.
[[nodiscard]] const char* message(StatusCode code);

} // namespace fjell
FJELL_API_END
