#include "editor/command.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "editor/files/settings.h"
#include "editor/measures.h"
#include "fjell/io/failure.h"
#include "fjell/profile.h"
#include "fjell/texture.h"
#include "io/stamps.h"

namespace fjell::editor {

namespace {

using io::Failure;

constexpr const char* a_point = "a point, from 0";

// The words after the verb. Quotes hold words with spaces together.
class Words {
public:
    explicit Words(std::vector<std::string> words) : words_(std::move(words)) {}

    [[nodiscard]] bool more() const { return at_ < words_.size(); }
    [[nodiscard]] std::string text(const char* what) {
        if (!more()) throw Failure(2, fmt::format("{} is missing", what));
        return words_[at_++];
    }
    [[nodiscard]] std::string text_or(std::string otherwise) { return more() ? words_[at_++] : std::move(otherwise); }
    [[nodiscard]] double number(const char* what) { return number_of(text(what), what); }
    [[nodiscard]] double number_or(double otherwise, const char* what) { return more() ? number(what) : otherwise; }
    [[nodiscard]] std::size_t count(const char* what) { return count_of(text(what), what); }
    // Whether the last word is that one; no other may be there.
    [[nodiscard]] bool flag(const char* name) {
        if (!more()) return false;
        const std::string word = text(name);
        if (word != name) throw Failure(2, fmt::format("{}: only {} may follow", word, name));
        return true;
    }
    [[nodiscard]] bool on() {
        const std::string word = text("on or off");
        if (word != "on" && word != "off") throw Failure(2, fmt::format("{}: must be on or off", word));
        return word == "on";
    }
    template <typename E>
    [[nodiscard]] E one_of(std::span<const char* const> names, const char* what) {
        const std::string word = text(what);
        std::string all;
        for (std::size_t i = 0; i < names.size(); ++i) {
            if (word == names[i]) return static_cast<E>(i);
            all += (all.empty() ? "" : ", ") + std::string(names[i]);
        }
        throw Failure(2, fmt::format("{}: no such {}; choose one of {}", word, what, all));
    }
    // NAME=VALUE words from here on.
    void options(const std::map<std::string, std::function<void(const std::string&)>>& known) {
        while (more()) {
            const std::string word = text("");
            const std::size_t sign = word.find('=');
            const auto found = sign == std::string::npos ? known.end() : known.find(word.substr(0, sign));
            if (found == known.end()) {
                std::string all;
                for (const auto& [name, set] : known) all += (all.empty() ? "" : ", ") + name + "=";
                throw Failure(2, fmt::format("{}: no such option; choose from {}", word, all));
            }
            found->second(word.substr(sign + 1));
        }
    }
    // NAME=..., which no file is called here; after a folder it may be.
    [[nodiscard]] bool is_option() const {
        const std::size_t sign = words_[at_].find('=');
        return sign != std::string::npos && sign != 0 && words_[at_].find('/') > sign;
    }
    void end() const {
        if (more()) throw Failure(2, fmt::format("{}: unexpected extra word", words_[at_]));
    }
    [[nodiscard]] static double number_of(const std::string& word, const char* what) {
        double value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
            throw Failure(2, fmt::format("{}: {} must be a number", word, what));
        return value;
    }
    [[nodiscard]] static std::uint32_t count_of(const std::string& word, const char* what, double least = 0,
                                                double most = 1e9) {
        const double value = number_of(word, what);
        if (!(value >= least && value <= most && value == std::floor(value)))
            throw Failure(2, fmt::format("{} must be a whole number from {} to {}", what, least, most));
        return static_cast<std::uint32_t>(value);
    }
    [[nodiscard]] static double number_in(const std::string& word, const char* what, double least, double most) {
        const double value = number_of(word, what);
        if (!(value >= least && value <= most))
            throw Failure(2, fmt::format("{} must be a number from {} to {}", what, least, most));
        return value;
    }

private:
    std::vector<std::string> words_;
    std::size_t at_ = 0;
};

struct Verb {
    const char *name, *words, *about;
    std::function<Command(Words&)> parse;
};

template <typename C>
std::function<Command(Words&)> plain() {
    return [](Words&) { return C{}; };
}
template <typename C>
std::function<Command(Words&)> with_path(bool needed) {
    return [=](Words& w) { return C{needed ? w.text("a file") : w.text_or("")}; };
}
template <typename C>
std::function<Command(Words&)> with_path_and_discard() {
    return [](Words& w) {
        const std::string path = w.text("a file");
        return C{path, w.flag("discard")};
    };
}
template <typename C>
std::function<Command(Words&)> with_switch() {
    return [](Words& w) { return C{w.on()}; };
}
template <typename C>
std::function<Command(Words&)> with_point() {
    return [](Words& w) { return C{w.count(a_point)}; };
}

[[nodiscard]] bool yes_or_no(const std::string& word, const char* what) {
    if (word != "yes" && word != "no") throw Failure(2, fmt::format("{}: {} must be yes or no", word, what));
    return word == "yes";
}

// Of an export: nothing, "converged" or a threshold; the size of its texels, and what makes the file smaller.
void mesh_choice(Words& w, ExportMesh& c) {
    if (w.more() && !w.is_option()) {
        const std::string word = w.text("");
        c.converged = word == "converged";
        if (!c.converged)
            c.error_px = Words::number_of(word, "the threshold, unless it is the word converged or texel_m=M,");
    }
    w.options({{"texel_m", [&](const std::string& v) { c.texel_m = Words::number_in(v, "texel_m", 0, 1e6); }},
               {"quantised", [&](const std::string& v) { c.quantised = yes_or_no(v, "quantised"); }},
               {"meshopt", [&](const std::string& v) { c.meshopt = yes_or_no(v, "meshopt"); }},
               {"texture", [&](const std::string& v) {
                    if (v != "png" && v != "jpeg") throw Failure(2, fmt::format("{}: texture must be png or jpeg", v));
                    c.jpeg = v == "jpeg";
                }}});
}

constexpr double degree = 3.14159265358979323846 / 180;

Command set_key(Words& w) {
    const std::string name = w.text("a key, as in a profile: refine.max_error_px");
    const ProfileKey* const key = find_profile_key(name);
    if (key == nullptr) throw Failure(2, fmt::format("{}: no such key; a saved profile lists them all", name));
    double value = 0;
    if (const std::string problem = parse_value(*key, w.text("a value"), value); !problem.empty())
        throw Failure(2, fmt::format("{}: {}", name, problem));
    return SetKey{key, value, false};
}

Command place_camera(Words& w) {
    PlaceCamera c;
    c.position_m = {w.number("x in metres"), w.number("y in metres"), w.number("z in metres")};
    c.heading_rad = w.number("the heading in degrees") * degree;
    c.pitch_rad = w.number("the pitch in degrees") * degree;
    return c;
}

Command arrange_column(Words& w) {
    ArrangeColumn c;
    c.column = w.one_of<Column>(column_names, "column");
    c.part = w.one_of<ColumnPart>(column_part_names, "part of a column");
    if (c.part == ColumnPart::folded)
        c.value = w.on() ? 1 : 0;
    else if (c.part == ColumnPart::width)
        c.value = Words::number_in(w.text("a width"), "a width", least_column_px, most_column_px);
    else
        c.value = Words::number_in(w.text("a share"), "a share", 0, 1);
    return c;
}

constexpr std::array<const char*, groups> all_group_names = [] {
    std::array<const char*, groups> names{};
    for (std::size_t i = 0; i < groups; ++i) names[i] = group_names[i].name;
    return names;
}();

Command show_panel(Words& w) {
    const std::string name = w.text("a panel");
    for (const auto& former : former_panels)
        if (name == former.name) return ShowGroup{former.group, true};
    Words again({name});
    return ShowPanel{again.one_of<Panel>(panel_names, "panel")};
}

Command place_panel(Words& w) {
    PlacePanel c;
    c.panel = w.one_of<Panel>(panel_names, "panel");
    const auto pixels = [&](const char* what, double least) {
        return Words::number_in(w.text(what), what, least, static_cast<double>(most_floating_px));
    };
    c.x_px = pixels("x in pixels", -static_cast<double>(most_floating_px));
    c.y_px = pixels("y in pixels", 0);
    c.width_px = pixels("the width in pixels", static_cast<double>(least_floating_px));
    c.height_px = pixels("the height in pixels", static_cast<double>(least_floating_px));
    return c;
}

Command bake(Words& w) {
    BakePack b;
    b.inputs.push_back(w.text("a file of heights"));
    b.output = w.text("the pack to write");
    while (w.more() && !w.is_option()) { // several files of heights: the pack comes last
        b.inputs.push_back(std::move(b.output));
        b.output = w.text("the pack to write");
    }
    w.options({{"tile", [&](const std::string& v) { b.tile = v == "auto" ? 0 : Words::count_of(v, "tile"); }},
               {"order", [&](const std::string& v) { b.order = v; }},
               {"nodata", [&](const std::string& v) { b.nodata = v; }},
               {"void", [&](const std::string& v) { b.voids = v; }},
               {"crs", [&](const std::string& v) { b.crs = v; }},
               {"memory_mb", [&](const std::string& v) { b.memory_mb = Words::count_of(v, "memory_mb"); }},
               {"texture", [&](const std::string& v) { b.texture = v; }},
               {"ramp", [&](const std::string& v) { b.ramp = v; }},
               {"layers", [&](const std::string& v) { b.rules = v; }},
               {"splat", [&](const std::string& v) { b.splat = v; }},
               {"horizons", [&](const std::string& v) { b.horizons = v; }},
               {"encoding", [&](const std::string& v) { b.encoding = v; }},
               {"bbox", [&](const std::string& v) { b.bbox = v; }},
               {"band", [&](const std::string& v) { b.band = v; }},
               {"size", [&](const std::string& v) { b.size = v; }},
               {"vertical-unit", [&](const std::string& v) { b.vertical_unit = v; }},
               {"texture-bands", [&](const std::string& v) { b.texture_bands = v; }},
               {"spacing", [&](const std::string& v) { b.spacing_m = Words::number_of(v, "spacing"); }},
               {"zscale", [&](const std::string& v) { b.height_scale = Words::number_of(v, "zscale"); }},
               {"zoffset", [&](const std::string& v) { b.height_offset_m = Words::number_of(v, "zoffset"); }}});
    return b;
}

Command tune(Words& w) {
    TuneThreshold t;
    TuneSettings& s = t.settings;
    w.options({{"measure",
                [&](const std::string& v) {
                    if (v != "update" && v != "frame")
                        throw Failure(2, fmt::format("{}: measure must be update or frame", v));
                    s.measure = v == "frame" ? TuneMeasure::frame : TuneMeasure::update;
                }},
               {"budget_us", [&](const std::string& v) { s.budget_us = Words::number_in(v, "budget_us", 10, 1e6); }},
               {"frames", [&](const std::string& v) { s.frames = Words::count_of(v, "frames", 0, 1e5); }},
               {"csv", [&](const std::string& v) { t.csv = v; }},
               {"apply", [&](const std::string& v) { s.apply = yes_or_no(v, "apply"); }},
               {"also", [&](const std::string& v) { s.also = yes_or_no(v, "also"); }},
               {"least_px",
                [&](const std::string& v) {
                    s.least_px = Words::number_in(v, "least_px", ranges::least_threshold_px, ranges::most_threshold_px);
                }},
               {"most_px", [&](const std::string& v) {
                    s.most_px = Words::number_in(v, "most_px", ranges::least_threshold_px, ranges::most_threshold_px);
                }}});
    return t;
}

Command brush(Words& w) {
    Brush b;
    b.tool = w.one_of<BrushTool>(brush_tool_names, "brush");
    const auto metres = [](double& to, const char* name, double least, double most) {
        return std::pair<std::string, std::function<void(const std::string&)>>(
            name, [&to, name, least, most](const std::string& v) { to = Words::number_in(v, name, least, most); });
    };
    w.options({metres(b.radius_m, "radius", least_brush_m, most_brush_m),
               metres(b.falloff_m, "falloff", 0, most_brush_m),
               metres(b.amount_m, "amount", -most_amount_m, most_amount_m),
               metres(b.strength, "strength", 0, 1),
               metres(b.error_m, "error", 0, most_lock_m),
               {"colour", [&](const std::string& v) { std::ranges::copy(io::rgb_of(v, "colour"), b.rgb); }},
               {"material", [&](const std::string& v) {
                    const double number = Words::number_in(v, "material", 0, max_splat_names - 1);
                    if (number != std::floor(number)) throw io::Failure(2, "material: give a whole number");
                    b.material = static_cast<std::uint8_t>(number);
                }}});
    return SetBrush{b};
}

Command stroke(Words& w) {
    StrokeGround s;
    do {
        const double x = w.number("x in metres");
        s.places.push_back({x, w.number("z in metres")});
    } while (w.more());
    return s;
}

Command edit_layer(Words& w) {
    const std::string what = w.text("add, choose, remove, on, off, strength or move");
    if (what == "add") return AddEditLayer{w.text("a name")};
    const std::size_t place = w.count("a layer's number");
    if (what == "choose") return ChooseEditLayer{place};
    if (what == "remove") return RemoveEditLayer{place};
    SetEditLayer s{place, {}, {}, {}};
    if (what == "on" || what == "off")
        s.on = what == "on";
    else if (what == "strength")
        s.strength = Words::number_in(w.text("a share"), "strength", 0, 1);
    else if (what == "move")
        s.to = w.count("its new place");
    else
        throw Failure(2, fmt::format("{}: must be add, choose, remove, on, off, strength or move", what));
    return s;
}

std::vector<Verb> terrain_verbs() {
    return {
        {"open", "FILE [discard]", "a pack, a profile, a camera path, or heights to bake",
         with_path_and_discard<OpenFile>()},
        {"sample", "", "the sample terrain, baked at its first use", plain<OpenSample>()},
        {"materials", "none|built-in|FILE [RULES]",
         "what near ground is drawn with, remembered for the terrain; RULES: alpine, nordic, canyon or a file",
         [](Words& w) {
             const std::string file = w.text("none, built-in or a file of materials");
             return ChooseMaterials{file == "none" ? "" : file, w.text_or("")};
         }},
        {"set", "KEY VALUE", "a value of the profile: set refine.max_error_px 2", set_key},
        {"undo", "", "reverts the last change of the profile, the camera path or the ground", plain<Undo>()},
        {"redo", "", "repeats what was undone", plain<Redo>()},
        {"light", "PRESET", "sun, air and exposure at once: relief, morning, noon, evening, dusk or haze",
         [](Words& w) { return SetLight{w.one_of<LightPreset>(light_preset_names, "preset")}; }},
        {"defaults", "", "resets the profile to its defaults", plain<ResetProfile>()},
        {"open-profile", "FILE [discard]", "another profile; asks about unsaved changes, or not",
         with_path_and_discard<OpenProfile>()},
        {"save-profile", "[FILE]", "the profile, where it came from or elsewhere", with_path<SaveProfile>(false)},
        {"compare", "[FILE]", "shows another profile's values beside; without FILE: the saved ones",
         with_path<CompareProfile>(false)},
        {"compare-off", "", "shows the profile alone", plain<StopComparing>()},
        {"browse", "[FOLDER]", "the folder that file dialogs list; without FOLDER: lists it again",
         [](Words& w) { return BrowseFolder{w.text_or("")}; }},
        {"browse-all", "on|off", "lists files of all kinds in file dialogs", with_switch<BrowseAllKinds>()},
        {"go-on", "save|discard|cancel", "answers the question about unsaved changes",
         [](Words& w) { return AnswerUnsaved{w.one_of<Answer>(answer_names, "answer")}; }},
        {"recover", "restore|discard", "unsaved changes of an earlier run",
         [](Words& w) {
             constexpr const char* ways[] = {"discard", "restore"};
             return RecoverChanges{w.one_of<int>(ways, "way") == 1};
         }},
        {"bake",
         "HEIGHTS... PACK [tile=N|auto] [texture=IMG] [ramp=FILE] [spacing=M] [zscale=S] [zoffset=M] "
         "[layers=RULES] [splat=full|half|quarter] [horizons=none|half|quarter] "
         "[encoding=none|terrarium|terrain-rgb] [bbox=W,S,E,N] [order=planar|hz|linear] "
         "[band=N|NAME] [size=COLUMNSxROWS] [vertical-unit=UNIT] [texture-bands=R,G,B|GREY] "
         "[nodata=hole|fill|refuse] [void=V,...|none] [crs=C] [memory_mb=N]",
         "bakes a pack and opens it; several files make a mosaic, a .json file is a recipe", bake},
        {"bake-file", "FILE [heights|another|output|texture|ramp|rules]",
         "puts a file into the dialog that bakes, and opens that; without a field, by the kind of the file",
         [](Words& w) {
             GiveBakeFile c{w.text("a file"), BakeField::none, false};
             constexpr const char* places[] = {"", "heights", "output", "texture", "ramp", "rules", "another"};
             if (!w.more()) return c;
             const int place = w.one_of<int>(places, "place");
             c.another = place == 6;
             c.field = c.another ? BakeField::heights : static_cast<BakeField>(place);
             return c;
         }},
        {"open-baked", "on|off", "flies the pack that was baked beside the terrain that is flown, or does not",
         with_switch<OpenBaked>()},
    };
}

std::vector<Verb> camera_verbs() {
    return {
        {"camera", "X Y Z HEADING PITCH", "places the camera; metres and degrees, heading clockwise from north",
         place_camera},
        {"jump", "X Z", "moves the camera over that position, in metres",
         [](Words& w) {
             const double x = w.number("x in metres");
             return JumpTo{x, w.number("z in metres")};
         }},
        {"home", "", "looks at the whole terrain", plain<ViewAll>()},
        {"speed", "M_S", "flying speed in metres per second", [](Words& w) { return SetSpeed{w.number("a speed")}; }},
        {"navigate", "fly|orbit|path", "how keys and mouse move the camera",
         [](Words& w) { return SetNavigation{w.one_of<Navigation>(navigation_names, "navigation")}; }},
        {"freeze", "on|off", "freezes refinement and culling at the current camera", with_switch<FreezeRefinement>()},
        {"open-path", "FILE [discard]", "a camera path; asks about unsaved changes, or not",
         with_path_and_discard<OpenPath>()},
        {"save-path", "[FILE]", "the path, where it came from or elsewhere", with_path<SavePath>(false)},
        {"record-path", "on|off", "records the flight of the camera", with_switch<RecordPath>()},
        {"play-path", "on|off", "flies along the path", with_switch<PlayPath>()},
        {"seek-path", "SHARE", "moves to a fraction of the path, 0 to 1",
         [](Words& w) { return SeekPath{Words::number_in(w.text("a share"), "a share", 0, 1)}; }},
        {"add-point", "", "adds the camera's pose after the selected point", plain<AddPoint>()},
        {"replace-point", "N", "replaces a point with the camera's pose", with_point<ReplacePoint>()},
        {"remove-point", "N", "removes a point", with_point<RemovePoint>()},
        {"move-point", "N TO", "moves a point to index TO",
         [](Words& w) {
             const std::size_t point = w.count(a_point);
             return MovePoint{point, w.count("its new index, from 0")};
         }},
        {"clear-path", "", "removes the path", plain<ClearPath>()},
        {"restore-path", "", "restores the path before it was last edited, cleared or replaced", plain<RestorePath>()},
        {"path-seconds", "N", "duration of the flight; 0: chosen from the terrain's size",
         [](Words& w) { return SetPathSeconds{w.number("seconds")}; }},
        {"loop-path", "on|off", "starts again at its end", with_switch<LoopPath>()},
    };
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

std::vector<Verb> picture_verbs() {
    return {
        {"probe", "X Y", "points the probe at a place of the picture, in shares of its width and height",
         [](Words& w) {
             const double x = Words::number_in(w.text("a share"), "a share", 0, 1);
             return PointProbe{x, Words::number_in(w.text("a share"), "a share", 0, 1)};
         }},
        {"mark", "X Z", "marks a place, in metres; the probe shows the way along all of them, and the area within",
         [](Words& w) {
             const double x = w.number("x in metres");
             return MarkPlace{x, w.number("z in metres")};
         }},
        {"brush", "TOOL [radius=M] [falloff=M] [amount=M] [strength=SHARE] [error=M] [colour=RRGGBB] [material=N]",
         "what the left button does to the ground: off, raise, lower, level, smooth, noise, crater, restore, hole, "
         "fill, road, paint, unpaint, lock or unlock; error: of lock, how far off the drawn ground may be",
         brush},
        {"stroke", "X Z [X Z ...]",
         "a stroke of the brush along these places, in metres; of a road: its corners, straight in between", stroke},
        {"edit-layer", "add NAME | choose|remove|on|off N | strength N SHARE | move N TO",
         "the layers that strokes lie on; N counts from the bottom, from 0", edit_layer},
        {"remove-mark", "", "removes the last mark", plain<RemoveMark>()},
        {"clear-marks", "", "removes all marks", plain<ClearMarks>()},
        {"mode", "NAME", "shaded, wire, levels, tiles, mips, residency or distance",
         [](Words& w) { return SetPictureMode{w.one_of<session::PictureMode>(session::picture_mode_names, "mode")}; }},
        {"overlay", "NAME on|off",
         "wireframe, tile-borders, page-borders, spheres, culled, error, path, contours or slope",
         [](Words& w) {
             const auto overlay = w.one_of<Overlay>(overlay_names, "overlay");
             return SetOverlay{overlay, w.on()};
         }},
        {"contours", "METRES|auto", "metres between contours, 0.01 to 10,000; auto: some 20 over the terrain's heights",
         [](Words& w) {
             const std::string word = w.text("metres, or auto");
             return SetContours{
                 word == "auto" ? 0
                                : Words::number_in(word, "metres between contours", least_contour_m, most_contour_m)};
         }},
        {"panel", "NAME", "tune, view, cost, auto-tune, pictures or light", show_panel},
        {"group", "PANEL.GROUP on|off", "unfolds a group of a panel and turns to it, or folds it: group cost.time on",
         [](Words& w) {
             const auto group = w.one_of<Group>(all_group_names, "group");
             return ShowGroup{group, w.on()};
         }},
        {"dialog", "NAME", "opens a dialog; none closes it",
         [](Words& w) { return ShowDialog{w.one_of<Dialog>(dialog_names, "dialog")}; }},
        {"interface", "panels|picture-only|panel-keys|half-resolution|probe on|off",
         "panels beside the picture, the picture alone, keys that move in the panels, half resolution while it moves, "
         "the probe",
         [](Words& w) {
             const auto which = w.one_of<Switch>(switch_names, "switch");
             return SetSwitch{which, w.on()};
         }},
        {"column", "left|right width|split|folded VALUE",
         "width in pixels of a scale of 1, the upper section's share, or on|off", arrange_column},
        {"float", "PANEL on|off", "a panel over the picture, or back in its column",
         [](Words& w) {
             const auto panel = w.one_of<Panel>(panel_names, "panel");
             return FloatPanel{panel, w.on(), {}};
         }},
        {"place-panel", "PANEL X Y WIDTH HEIGHT",
         "where a panel that floats lies, in pixels of a scale of 1 from the window's corner", place_panel},
        {"scale", "S", "scale of the interface, 0.5 to 4",
         [](Words& w) { return SetScale{Words::number_in(w.text("a scale"), "a scale", 0.5, 4)}; }},
        {"frame-report", "AGO|off", "shows what a measured frame cost, 0 the newest",
         [](Words& w) {
             const std::string word = w.text("frames ago");
             if (word == "off") return Command(ChooseFrame{});
             return Command(ChooseFrame{true, Words::count_of(word, "frames ago", 0, measured_frames - 1.0)});
         }},
        {"hold-graphs", "on|off", "graphs and times stand still, to be looked at", with_switch<HoldMeasures>()},
        {"zoom-graphs", "OLDEST NEWEST", "holds the graphs and shows these frames of them, in frames ago",
         [](Words& w) {
             const auto ago = [&w] {
                 return Words::count_of(w.text("frames ago"), "frames ago", 0, measured_frames - 1.0);
             };
             const std::size_t oldest = ago();
             return ZoomGraphs{oldest, ago()};
         }},
        {"dismiss", "", "hides the message", plain<DismissMessage>()},
    };
}

std::vector<Verb> program_verbs() {
    return {
        {"tune",
         "[measure=update|frame] [budget_us=N] [frames=N] [least_px=E] [most_px=E] [also=yes|no] [apply=yes|no] "
         "[csv=FILE]",
         "the smallest threshold whose p99 keeps the budget; also tunes off-screen factor, hysteresis and morphing; "
         "apply sets what was found",
         tune},
        {"use-tuned", "", "sets what auto-tuning found last, in one step of undo", plain<UseTuned>()},
        {"benchmark", "FILE.csv [FRAMES]", "flies the path and writes one line per frame",
         [](Words& w) {
             const std::string path = w.text("a file");
             return RunBenchmark{path, w.more() ? w.count("frames") : 0};
         }},
        {"export", "FILE.glb [converged|ERROR_PX] [texel_m=M] [quantised=yes|no] [meshopt=yes|no] [texture=png|jpeg]",
         "the mesh as drawn now, or the converged mesh of this view, or the whole terrain at a threshold",
         [](Words& w) {
             ExportMesh c{w.text("a file")};
             mesh_choice(w, c);
             return c;
         }},
        {"preview", "[converged|ERROR_PX] [options of export]", "counts and file size of an export; nothing is written",
         [](Words& w) {
             PreviewExport c;
             mesh_choice(w, c.mesh);
             return c;
         }},
        {"cancel", "", "cancels the running job", plain<CancelJob>()},
        {"screenshot", "FILE.png [terrain]", "the window, or the terrain alone",
         [](Words& w) {
             const std::string path = w.text("a file");
             return TakeScreenshot{path, !w.flag("terrain")};
         }},
        {"resize", "WIDTH HEIGHT", "resizes the window, in pixels",
         [](Words& w) {
             const std::uint32_t width = Words::count_of(w.text("a width"), "a width", 320, 8192);
             return ResizeWindow{width, Words::count_of(w.text("a height"), "a height", 320, 8192)};
         }},
        {"dump", "FILE.json", "the editor's state", with_path<DumpState>(true)},
        {"lose-graphics", "", "recreates all GPU resources, as after a driver reset", plain<LoseGraphics>()},
        {"frames", "N", "waits for N frames", [](Words& w) { return WaitFrames{w.count("frames")}; }},
        {"wait", "", "waits until the mesh has converged, streaming has finished and no job runs",
         plain<WaitSettled>()},
        {"quit", "[discard]", "asks about unsaved changes, or not", [](Words& w) { return Quit{w.flag("discard")}; }},
    };
}

Command render(Words& w) {
    RenderPicture r;
    r.path = w.text("a file");
    w.options({{"width", [&](const std::string& v) { r.width = Words::count_of(v, "width", 16, 32768); }},
               {"height", [&](const std::string& v) { r.height = Words::count_of(v, "height", 16, 32768); }}});
    return r;
}

Command compare_pictures(Words& w) {
    const std::string word = w.text("off, profile, half or a threshold");
    if (word == "off") return ComparePictures{};
    if (word == "half") return ComparePictures{CompareWith::half, 0};
    if (word == "profile") return ComparePictures{CompareWith::profile, 0};
    return ComparePictures{CompareWith::threshold,
                           Words::number_in(word, "the threshold, unless off, profile or half,",
                                            ranges::least_threshold_px, ranges::most_threshold_px)};
}

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
        {"compare-picture", "off|profile|half|ERROR_PX",
         "draws the compared profile, or this one at another threshold or with half the triangles, into the same "
         "picture",
         compare_pictures},
        {"compare-view", "split|difference", "both sides of a divider, or how much the pictures differ",
         [](Words& w) { return SetCompareView{w.one_of<CompareView>(compare_view_names, "view")}; }},
        {"divider", "SHARE", "where the compared picture begins, 0 to 1 of the width",
         [](Words& w) { return SetDivider{Words::number_in(w.text("a share"), "a share", 0, 1)}; }},
    };
}

const std::vector<Verb>& verbs() {
    static const std::vector<Verb> all = [] {
        std::vector<Verb> list = terrain_verbs();
        for (auto* const more : {camera_verbs, path_verbs, picture_verbs, program_verbs, study_verbs})
            for (Verb& verb : more()) list.push_back(std::move(verb));
        return list;
    }();
    return all;
}

std::vector<std::string> split(std::string_view line) {
    std::vector<std::string> words;
    bool quoted = false, inside = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
            if (!inside) words.emplace_back();
            inside = true;
        } else if (!quoted && (c == ' ' || c == '\t' || c == '\r')) {
            inside = false;
        } else {
            if (!inside) words.emplace_back();
            inside = true;
            words.back() += c;
        }
    }
    if (quoted) throw Failure(2, "a quote is not closed");
    return words;
}

} // namespace

std::optional<Command> parse_command(std::string_view line) {
    std::vector<std::string> all = split(line);
    if (all.empty() || all[0].starts_with('#')) return {};
    const std::string name = all[0];
    for (const Verb& verb : verbs()) {
        if (name != verb.name) continue;
        all.erase(all.begin());
        try {
            Words words(std::move(all));
            Command command = verb.parse(words);
            words.end();
            return command;
        } catch (const Failure& failure) {
            throw Failure(2, fmt::format("{}: {}; usage: {} {}", name, failure.what(), verb.name, verb.words));
        }
    }
    throw Failure(2, fmt::format("{}: no such command; fjell-editor --help-commands lists them", name));
}

Command::Command(const Command& from) = default;
Command::Command(Command&& from) noexcept = default;
Command& Command::operator=(const Command& from) = default;
Command& Command::operator=(Command&& from) noexcept = default;
Command::~Command() = default;

std::string command_help() {
    std::string text;
    for (const Verb& verb : verbs())
        text += fmt::format("{}{}{}\n    {}\n", verb.name, *verb.words ? " " : "", verb.words, verb.about);
    return text;
}

} // namespace fjell::editor
