// One function a command; apply() finds the one. They may throw io::Failure, which becomes a message.
#pragma once

#include "editor/handlers/apply.h"

namespace fjell::editor {

// carry_out_profile.cpp
void carry_out(const SetKey& c, Desk desk);
void carry_out(const Undo& c, Desk desk);
void carry_out(const Redo& c, Desk desk);
void carry_out(const DefaultProfile& c, Desk desk);
void carry_out(const OpenProfile& c, Desk desk);
void carry_out(const SaveProfile& c, Desk desk);
void carry_out(const CompareProfile& c, Desk desk);
void carry_out(const StopComparing& c, Desk desk);

// carry_out_files.cpp
void carry_out(const Open& c, Desk desk);
void carry_out(const OpenSample& c, Desk desk);
void carry_out(const Browse& c, Desk desk);
void carry_out(const BrowseAll& c, Desk desk);
void carry_out(const GoOn& c, Desk desk);
void carry_out(const Recover& c, Desk desk);
// Before a command that would lose changes: asks about them and remembers it. again: the command as it is carried out
// once it is answered. True: it was asked, and nothing is to be done now.
[[nodiscard]] bool asks_first(Command again, Desk desk);
// After something was saved: goes on with what waited for it.
void go_on_saving(Desk desk);
// A dialogue opens: what it looks at is read, and what waited for another one waits no longer.
void dialog_opens(Dialog dialog, State& state);
// A pack was opened: it is a recent one now, and the page that asked what to open goes.
void opened_pack(const std::string& path, State& state);
// "* laptop.toml - alps.fjell - Fjell editor"
[[nodiscard]] std::string title(const State& state);
// At the start: settings are read, and what an earlier run left is found. In a window both are written from now on.
void begin_keeping(State& state, bool window);
// Once a frame: what is made from the document, for as long as it is the same; and changes are kept from crashes.
void keep_up(State& state);
// At the end. wanted: the user's will, and nothing is left to recover; else changes are kept for the next run.
void end_keeping(State& state, bool wanted);

// carry_out_camera.cpp
void carry_out(const Move& c, Desk desk);
void carry_out(const PlaceCamera& c, Desk desk);
void carry_out(const JumpTo& c, Desk desk);
void carry_out(const LookAtAll& c, Desk desk);
void carry_out(const SetSpeed& c, Desk desk);
void carry_out(const Navigate& c, Desk desk);
void carry_out(const Freeze& c, Desk desk);
void carry_out(const OpenPath& c, Desk desk);
void carry_out(const SavePath& c, Desk desk);
void carry_out(const RecordPath& c, Desk desk);
void carry_out(const PlayPath& c, Desk desk);
void carry_out(const SeekPath& c, Desk desk);
void carry_out(const AddPoint& c, Desk desk);
void carry_out(const ReplacePoint& c, Desk desk);
void carry_out(const RemovePoint& c, Desk desk);
void carry_out(const SelectPoint& c, Desk desk);
void carry_out(const MovePoint& c, Desk desk);
void carry_out(const ClearPath& c, Desk desk);
void carry_out(const RestorePath& c, Desk desk);
void carry_out(const PathSeconds& c, Desk desk);
void carry_out(const LoopPath& c, Desk desk);

void end_recording(Desk desk);

// carry_out_show.cpp
void carry_out(const SetMode& c, Desk desk);
void carry_out(const SetOverlay& c, Desk desk);
void carry_out(const ShowPanel& c, Desk desk);
void carry_out(const ShowDialog& c, Desk desk);
void carry_out(const SetScale& c, Desk desk);
void carry_out(const DismissMessage& c, Desk desk);
void carry_out(const Quit& c, Desk desk);

// carry_out_jobs.cpp
void carry_out(const Bake& c, Desk desk);
void carry_out(const Tune& c, Desk desk);
void carry_out(const Benchmark& c, Desk desk);
void carry_out(const Export& c, Desk desk);
void carry_out(const PreviewExport& c, Desk desk);
void carry_out(const CancelJob& c, Desk desk);
// What a job that has just ended means for the state: a baked pack is opened, a tuned threshold offered.
void take_result(Desk desk);

// The surface's and the script's: the app carries them out itself (editor/app.h).
inline void carry_out(const Screenshot&, Desk) {}
inline void carry_out(const Resize&, Desk) {}
inline void carry_out(const DumpState&, Desk) {}
inline void carry_out(const LoseGraphics&, Desk) {}
inline void carry_out(const WaitFrames&, Desk) {}
inline void carry_out(const WaitThere&, Desk) {}

} // namespace fjell::editor
