// What an editor may show: panels, dialogs, and what lies over the picture and the overview, alone and all at once.
// What its own code costs and allocates is measured in each (bench_editor, system_editor_purity).
#pragma once

#include <string>
#include <vector>

#include "editor/names.h"

namespace fjell::test {

struct Sight {
    std::string name;
    std::vector<std::string> commands; // that show it and take no frames
};

// Panels and dialogs, one after the other: each takes the place of the one before.
inline std::vector<Sight> panels_and_dialogs() {
    std::vector<Sight> sights;
    for (const char* panel : editor::panel_names)
        sights.push_back({std::string("panel:") + panel, {std::string("panel ") + panel}});
    for (const editor::GroupName& group : editor::group_names)
        if (!group.opens)
            sights.push_back({std::string("group:") + group.name, {std::string("group ") + group.name + " on"}});
    for (const char* dialog : editor::dialog_names)
        sights.push_back({std::string("dialog:") + dialog, {std::string("dialog ") + dialog}});
    return sights;
}

// Before what lies over the picture and the overview can be shown: two benchmarks are flown and kept, with CSV files in
// that folder, of so many frames. Needs a path, and takes frames.
inline std::vector<std::string> flown_runs(const std::string& folder, int frames = 600) {
    const std::string many = ".csv " + std::to_string(frames);
    return {"benchmark " + folder + "/a" + many, "wait", "benchmark " + folder + "/b" + many, "wait"};
}

// Each is shown with those before it; the last is everything. Needs flown_runs() and, before the camera moves, the
// compared picture.
inline const std::vector<std::string> compared_picture{"compare-picture 20", "wait"};
inline std::vector<Sight> overlays_in_turn() {
    std::vector<Sight> sights{
        {"runs", {"panel auto-tune"}},
        {"runs:place", {"run-place 0 0.5", "play-path on"}},
        {"heat", {"group view.map on", "heat time"}},
        {"probe", {"interface probe on", "probe 0.5 0.9"}},
        {"marks", {"mark 500 500", "mark 1500 900"}},
        {"compared:split", {"compare-view split", "group view.compare on"}},
        {"compared:difference", {"compare-view difference"}},
    };
    Sight all{"everything", {"compare-view split", "panel tune"}};
    for (const char* overlay : editor::overlay_names) all.commands.push_back(std::string("overlay ") + overlay + " on");
    for (const char* panel : editor::panel_names)
        if (panel != std::string("tune")) all.commands.push_back(std::string("float ") + panel + " on");
    sights.push_back(std::move(all));
    return sights;
}

} // namespace fjell::test
