// The verbs of editor/path_command.h.
#include <algorithm>

#include "editor/command_words.h"

namespace fjell::editor {

namespace {

constexpr const char* a_point = "a point, from 0";

// [FROM TO]; the same point twice is that one.
template <typename C>
C with_points(C command, Words& w) {
    if (!w.more()) return command;
    const std::size_t from = w.count(a_point), to = w.count(a_point);
    command.first = std::min(from, to);
    command.last = std::max(from, to);
    return command;
}

Command aim_path(Words& w) {
    const std::string word = w.text("x in metres, or off");
    if (word == "off") return with_points(FreePath{}, w);
    AimPath aim;
    aim.x_m = Words::number_of(word, "x in metres");
    aim.z_m = w.number("z in metres");
    return with_points(aim, w);
}

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
        {"time-point", "N SECONDS",
         "when the camera passes a point, between its neighbours; the last one: the duration",
         [](Words& w) {
             const std::size_t point = w.count(a_point);
             return TimePoint{point, w.number("seconds"), false};
         }},
        {"stretch-speed", "N M_S", "mean speed from a point to the next; the times of the points after it follow",
         [](Words& w) {
             const std::size_t point = w.count(a_point);
             return PaceStretch{point, w.number("a speed"), false};
         }},
        {"path-speed", "constant|ease", "flies the path at one speed, or from rest to rest, in the same duration",
         [](Words& w) { return PacePath{w.one_of<Pace>(pace_names, "way to fly")}; }},
        {"aim-path", "X Z|off [FROM TO]",
         "keeps the camera on a target, that place on the ground, all along or from one point to another; off: on none",
         aim_path},
        {"close-path", "on|off", "leads the path back to its first point without a jump, or ends it at its last",
         with_switch<ClosePath>()},
        {"circle-path", "[SECONDS]", "a closed camera path once around what the camera looks at",
         [](Words& w) { return CirclePath{w.number_or(20, "seconds")}; }},
    };
}

} // namespace fjell::editor
