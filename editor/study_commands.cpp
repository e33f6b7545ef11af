// The verbs of editor/study_command.h.
#include "editor/command_words.h"
#include "flight/profile.h"

namespace fjell::editor {

namespace {

Command render(Words& w) {
    RenderPicture r;
    r.path = w.text("a file");
    w.options({{"width", [&](const std::string& v) { r.width = Words::count_of(v, "width", 16, 32768); }},
               {"height", [&](const std::string& v) { r.height = Words::count_of(v, "height", 16, 32768); }}});
    return r;
}

Command compare_pictures(Words& w) {
    const std::string word = w.text("off, profile or a threshold");
    if (word == "off") return ComparePictures{};
    if (word == "profile") return ComparePictures{CompareWith::profile, 0};
    return ComparePictures{CompareWith::threshold, Words::number_in(word, "the threshold, unless off or profile,",
                                                                    flight::min_error_px, flight::max_error_px)};
}

} // namespace

std::vector<Verb> study_verbs() {
    return {
        {"run-place", "RUN SHARE", "chooses a place of a benchmark's run, 0 the latest, and looks from there",
         [](Words& w) {
             const std::size_t run = w.count("a run, from 0");
             return ChoosePlace{run, Words::number_in(w.text("a share"), "a share", 0, 1)};
         }},
        {"forget-run", "RUN", "drops a benchmark's run from the panel; its CSV stays",
         [](Words& w) { return ForgetRun{w.count("a run, from 0")}; }},
        {"heat", "none|time|error", "colours the overview along the latest run's path",
         [](Words& w) { return SetHeat{w.one_of<Heat>(heat_names, "heat")}; }},
        {"render", "FILE.png [width=W] [height=H]", "a picture of any size of what the camera sees", render},
        {"add-bookmark", "[NAME]", "keeps the camera's pose", [](Words& w) { return AddBookmark{w.text_or("")}; }},
        {"bookmark", "N", "looks from a bookmark, 0 the first",
         [](Words& w) { return GoToBookmark{w.count("a bookmark, from 0")}; }},
        {"remove-bookmark", "N", "removes a bookmark",
         [](Words& w) { return RemoveBookmark{w.count("a bookmark, from 0")}; }},
        {"compare-picture", "off|profile|ERROR_PX",
         "draws the compared profile, or this one at another threshold, into the same picture", compare_pictures},
        {"compare-view", "split|difference", "both sides of a divider, or how much the pictures differ",
         [](Words& w) { return SetCompareView{w.one_of<CompareView>(compare_view_names, "view")}; }},
        {"divider", "SHARE", "where the compared picture begins, 0 to 1 of the width",
         [](Words& w) { return SetDivider{Words::number_in(w.text("a share"), "a share", 0, 1)}; }},
    };
}

} // namespace fjell::editor
