// The verbs of editor/path_command.h.
#include <algorithm>

#include "editor/command_words.h"

namespace fjell::editor {

namespace {

constexpr const char* a_point = "a point, from 0";

Command place_point(Words& w) {
    PlacePoint place;
    place.point = w.count(a_point);
    place.x_m = w.number("x in metres");
    place.z_m = w.number("z in metres");
    if (w.more()) place.y_m = w.number("y in metres");
    return place;
}

Command insert_point(Words& w) {
    InsertPoint insert;
    if (w.more()) insert.share = Words::number_in(w.text("a share"), "a share", 0, 1);
    return insert;
}

} // namespace

std::vector<Verb> path_verbs() {
    return {
        {"select-point", "N [stay]", "selects a point and looks from there, or stays",
         [](Words& w) {
             const std::size_t point = w.count(a_point);
             return SelectPoint{point, !w.flag("stay")};
         }},
        {"insert-point", "[SHARE]",
         "adds a point on the path, at a fraction of its duration, or where it is being played", insert_point},
        {"place-point", "N X Z [Y]",
         "moves a point over that place, as high above the ground as it was, or to height Y", place_point},
    };
}

} // namespace fjell::editor
