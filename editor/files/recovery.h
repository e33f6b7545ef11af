// Changes that are not saved, kept where a crash or a kill does not reach them, and found by the next run.
//
// Every editor has a file of its own, <folder>/unsaved-PID-N.json, and holds a lock beside it while it lives: what no
// living editor holds was left by one that is no more. Thread: the frame's. Writing goes to the system's memory and
// waits for no disk: it survives the program, not the machine. Memory: nothing is allocated unless something has
// changed. Failure: one line, once; never an exception.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "editor/document.h"
#include "editor/route.h"

namespace fjell::editor {

// What an earlier run left.
struct Unsaved {
    Profile profile;
    bool profile_changed = false;
    std::string path;                          // of the profile's file; empty: it had none
    std::string pack;                          // that was open; empty: none
    std::vector<session::ControlPoint> points; // of the camera's path, when that was not saved
    double path_seconds = 0;                   // that it shall take; 0: as suits the terrain
};

class Recovery {
public:
    Recovery() = default;
    ~Recovery(); // the file stays: remove() is what a clean end calls
    Recovery(const Recovery&) = delete;
    Recovery& operator=(const Recovery&) = delete;

    // Looks for what was left, the latest first, and holds it, so that no other editor offers it too.
    void find(const std::string& folder);
    [[nodiscard]] const std::optional<Unsaved>& found() const { return found_; }
    // It was restored, or shall not be: gone, and the next one is looked for.
    void drop_found();
    // From now on keep() writes there. None: it does nothing.
    void start(const std::string& folder) { folder_ = folder; }
    // Once a frame: writes when something has changed, at most every two seconds, and removes what is saved by now.
    void keep(const Document& document, const Route& route, const std::string& pack, double now_s);
    // At once: the program is about to end, and not of its own will.
    void keep_now(const Document& document, const Route& route, const std::string& pack);
    void remove();
    [[nodiscard]] std::string take_problem();                       // one line, each only once; empty: none
    [[nodiscard]] const std::string& file() const { return file_; } // empty: nothing is kept

private:
    void write(const Document& document, const Route& route, const std::string& pack);
    [[nodiscard]] bool take(const std::string& file);
    void make_file();
    void report_once(std::string problem);

    std::string folder_, file_;
    int lock_ = -1;
    std::string found_folder_, found_file_;
    int found_lock_ = -1;
    std::optional<Unsaved> found_;
    std::string problem_;
    bool reported_ = false;
    double written_s_ = -1e9;
    std::uint64_t version_ = 0, points_hash_ = 0; // of what was written
};

} // namespace fjell::editor
