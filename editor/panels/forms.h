// Fields of forms, with their labels under each other, and how a form's job goes: for dialogs and panels of jobs.
//
// Thread: the frame's, inside a window. Each is marked as "group.name" and explains itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "editor/command.h"
#include "editor/panels/ui.h"
#include "editor/state.h"

namespace fjell::editor::fields {

inline constexpr std::size_t path_bytes = 1024;
using PathText = char[path_bytes];
void copy(PathText& to, const std::string& from);

// The label's column; the field that follows takes the rest.
void label(const char* text);
void path(const char* text, const char* group, const char* name, PathText& text_of, const char* hint,
          const char* about);
void number(const char* text, const char* group, const char* name, double& value, const char* format,
            const char* about);
void whole(const char* text, const char* group, const char* name, int& value, const char* about); // at least 0
void choice(const char* text, const char* group, const char* name, int& value, std::span<const char* const> names,
            const char* about);
// True when it is pressed; grey while it cannot be.
[[nodiscard]] bool button(const char* text, const char* group, const char* name, bool enabled, const char* about,
                          bool primary = false);

[[nodiscard]] bool runs(const State& state, JobKind kind);
void cancel(const char* group, Commands& commands);
// Beside a dialog's other buttons; a job goes on without it.
void close(const char* group, Commands& commands);
// How the last job of that kind ended, or how far this one is; or that another one runs.
void outcome(const State& state, JobKind kind, bool with_rate = false);

// A name after the pack's, where the program was started: terrain.fjell and ".csv" make terrain.csv. made_for: the pack
// that it was suggested for; another one's name is none of a path.
inline constexpr const char* nothing_yet = "\n";
void suggest(PathText& path, std::string& made_for, const State& state, const char* ending);
// Where a name that begins in no folder leads to: nobody sees where a program was started.
void destination(const char* group, const PathText& path);

} // namespace fjell::editor::fields

// --- The part of file dialogs that chooses a file: a folder's list, ways to other folders, and a name to type.

namespace fjell::editor {

// What is being typed and asked in the dialog that is open: nothing else of the editor needs it.
struct FileBrowserForm {
    char name[512] = {};
    bool asks = false;        // about overwriting that file
    std::uint64_t frame = 0;  // that it was drawn in last, in
    Dialog of = Dialog::none; // this dialog
    bool nested = false;      // over another dialog, which stays
    bool cancelled = false;   // of such a one: its button was pressed
    // What has the keyboard in a folder that has just been gone to, as in the one before.
    enum class Focus : std::uint8_t { stays, list, name } focuses = Focus::stays;
    std::string of_folder; // the one before
};
// A dialog that opens starts again, with that name in it.
void begin_file_browser(FileBrowserForm& form, const State& state, const char* name);
// button: what choosing is called. True: a name was chosen, and it is no folder.
[[nodiscard]] bool draw_file_browser(const State& state, Commands& commands, FileBrowserForm& form, const char* button);
// The same in a window of its own over another dialog. name: what it begins with. chose: form.name was, and it is no
// folder; closed: nothing was.
enum class NestedBrowser : std::uint8_t { open, chose, closed };
[[nodiscard]] NestedBrowser draw_nested_browser(const State& state, Commands& commands, FileBrowserForm& form,
                                                const char* name);
// Instead of the browser while form.asks. True: the file may be overwritten.
[[nodiscard]] bool draw_overwrite(FileBrowserForm& form);

} // namespace fjell::editor
