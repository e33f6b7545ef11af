// Where a profile key's value lies on its slider, and back.
//
// Thread: any. Complexity: O(1), allocates nothing. Failure: none; a share outside 0..1 is the nearest end.
#pragma once

#include <cstddef>
#include <string_view>

#include "editor/state.h"
#include "fjell/profile/keys.h"

namespace fjell::editor {

// 0 for the key's least, 1 for its most; logarithmic where the key says so, with a stretch for 0 where that is allowed.
[[nodiscard]] double slider_share(const ProfileKey& key, double value);
// In range, three digits of it, whole where the key is; exactly least and most at the ends.
[[nodiscard]] double slider_value(const ProfileKey& key, double share);

// The unit in which the window shows a key and has it typed: milliseconds for times that a profile has in microseconds,
// as everywhere else in the window.
struct ShownUnit {
    const char* name; // "" where there is none
    double share;     // of it is one of the key's own: 0.001
};
[[nodiscard]] ShownUnit shown_unit(const ProfileKey& key);

// As a text field shows it, in the shown unit; the key's word for 0. Never more than size bytes with the zero at the
// end.
void write_value(const ProfileKey& key, double value, char* to, int size);
// What was typed, in the key's own unit, in or out of range. False: no number, nor the key's word for 0.
[[nodiscard]] bool typed_value(const ProfileKey& key, std::string_view text, double& value);

// --- What a profile's key costs now, for the line below its control.

// False: there is nothing to say of that key. Allocates nothing.
[[nodiscard]] bool cost_text(const ProfileKey& key, const State& state, char* to, std::size_t size);
// Why the key has no effect now; null: it has.
[[nodiscard]] const char* why_idle(const ProfileKey& key, const State& state);
// Where its control is.
[[nodiscard]] Group group_of(const ProfileKey& key);

} // namespace fjell::editor
