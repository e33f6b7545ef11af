// What the editor keeps from one run to the next: settings, recent packs, and unsaved changes that a crash must not
// lose.
//
// Thread: the frame's. Memory: update_file_state() allocates nothing while nothing has changed. Failure: none is
// thrown; what cannot be read or written becomes a message.
#pragma once

#include <string>

#include "editor/state.h"

namespace fjell::editor {

// At the start: reads the settings and finds what an earlier run left. writes: settings and changes are written from
// now on; false for a script, which keeps nothing.
void start_persistence(State& state, bool writes);
// Once a frame: the title and the differences follow the document, and unsaved changes are written every 2 s.
void update_file_state(State& state);
// At the end. clean: the user has quit, and nothing is left to recover; otherwise changes are kept for the next run.
void finish_persistence(State& state, bool clean);

// Makes an opened pack the first of the recent ones, and closes the dialog that asked for it.
void remember_pack(const std::string& path, State& state);

// What was chosen for that pack; null: nothing.
[[nodiscard]] const PackMaterials* remembered_materials(const std::string& pack, const State& state);
void remember_materials(PackMaterials chosen, State& state);

} // namespace fjell::editor
