// What a profile's key costs now, for the line below its control.
#pragma once

#include <cstddef>

#include "editor/state.h"
#include "flight/profile_keys.h"

namespace fjell::editor {

// False: there is nothing to say of that key. Allocates nothing.
[[nodiscard]] bool cost_text(const flight::ProfileKey& key, const State& state, char* to, std::size_t size);
// Why the key does not count now; null: it does.
[[nodiscard]] const char* why_idle(const flight::ProfileKey& key, const State& state);

} // namespace fjell::editor
