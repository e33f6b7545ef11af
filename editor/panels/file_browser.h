// The part of file dialogs that chooses a file: a folder's list, ways to other folders, and a name to type.
#pragma once

#include <cstdint>

#include "editor/command.h"
#include "editor/state.h"

namespace fjell::editor {

// What is being typed and asked in the dialog that is open: nothing else of the editor needs it.
struct FileBrowserForm {
    char name[512] = {};
    bool asks = false;        // about overwriting that file
    std::uint64_t frame = 0;  // that it was drawn in last, in
    Dialog of = Dialog::none; // this dialog
    bool nested = false;      // over another dialog, which stays
    bool cancelled = false;   // of such a one: its button was pressed
};
// A dialog that opens starts again, with that name in it.
void begin_file_browser(FileBrowserForm& form, const State& state, const char* name);
// button: what choosing is called. True: a name was chosen, and it is no folder.
[[nodiscard]] bool draw_file_browser(const State& state, Commands& commands, FileBrowserForm& form, const char* button);
// Instead of the browser while form.asks. True: the file may be overwritten.
[[nodiscard]] bool draw_overwrite(FileBrowserForm& form);

} // namespace fjell::editor
