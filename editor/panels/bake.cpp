// The dialog that bakes: what is read and written on its left, what was found in the files on its right, and below
// what will happen. What is typed lives here, and goes to the state as a draft, which is looked at
// (jobs/height_look.h).
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/fields.h"
#include "editor/panels/file_browser.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

constexpr const char* tile_names[] = {strings::common::auto_, "64", "128", "256", "512", "1024", "2048"};
constexpr const char* order_names[] = {"planar", "hz", "linear"};
constexpr const char* nodata_names[] = {strings::bake::auto_holes_suspicious_values_refused, "hole", "fill", "refuse"};
constexpr const char* control_names[] = {"full", "half", "quarter"};
constexpr const char* horizon_names[] = {strings::common::none, "half", "quarter"};
constexpr const char* encoding_names[] = {strings::common::none, "terrarium", "terrain-rgb"};
constexpr int usual_control = 1; // fjell-bake's default

constexpr double bytes_a_sample[] = {1.3, 3.0}; // of packs: smooth large fields, rough small ones; with maps
constexpr double samples_a_second = 6e6, warped_a_second = 3e6; // on two cores; about
// What maps add a sample, in the order of their names: docs/notes/horizons.md and materials.md.
constexpr double control_bytes[] = {9.9, 2.6, 0.7}, control_a_second[] = {2e6, 6e6, 2e7};
constexpr double horizon_bytes[] = {0, 2.7, 0.7}, horizons_a_second[] = {0, 6e6, 1.3e7};
constexpr ImU32 marked = IM_COL32(104, 80, 24, 255);
constexpr float picture_em = 10.5F; // high

struct BakeForm {
    std::uint64_t given = ~std::uint64_t{0}; // BakeDraft::given that it holds
    fields::PathText input = "", output = "", texture = "", ramp = "", rules = "", voids = "", crs = "", bbox = "";
    std::vector<std::string> more; // heights, beside the first
    bool output_is_chosen = false;
    int tile = 0, order = 0, nodata = 0, control = usual_control, horizons = 0, encoding = 0;
    double spacing_m = 0, height_scale = 1, height_offset_m = 0;
    BakePack sent;
    BakeField browsing = BakeField::none; // for this one's file
    bool browsing_another = false;
    FileBrowserForm browser, overwrite;
};

int index_of_name(const std::string& name, const char* const* names, int count) {
    for (int i = 0; i < count; ++i)
        if (name == names[i]) return i;
    return 0;
}

void load(BakeForm& form, const BakeDraft& draft) {
    const BakePack& b = draft.pack;
    form.given = draft.given;
    fields::copy(form.input, b.inputs.empty() ? "" : b.inputs.front());
    form.more.assign(b.inputs.begin() + (b.inputs.empty() ? 0 : 1), b.inputs.end());
    fields::copy(form.output, b.output);
    form.output_is_chosen = draft.output_is_chosen;
    fields::copy(form.texture, b.texture);
    fields::copy(form.ramp, b.ramp);
    fields::copy(form.rules, b.rules);
    fields::copy(form.bbox, b.bbox);
    form.control =
        b.control.empty() ? usual_control : index_of_name(b.control, control_names, std::size(control_names));
    form.horizons = index_of_name(b.horizons, horizon_names, std::size(horizon_names));
    form.encoding = index_of_name(b.encoding, encoding_names, std::size(encoding_names));
    fields::copy(form.voids, b.voids);
    fields::copy(form.crs, b.crs);
    form.tile = b.tile == 0 ? 0 : index_of_name(std::to_string(b.tile), tile_names, std::size(tile_names));
    form.order = index_of_name(b.order, order_names, std::size(order_names));
    form.nodata = index_of_name(b.nodata, nodata_names, std::size(nodata_names));
    form.spacing_m = b.spacing_m;
    form.height_scale = b.height_scale;
    form.height_offset_m = b.height_offset_m;
    form.sent = b;
}

BakePack bake_of(const BakeForm& form) {
    BakePack b;
    if (form.input[0] != '\0') b.inputs = {form.input};
    b.inputs.insert(b.inputs.end(), form.more.begin(), form.more.end());
    b.output = form.output;
    b.texture = form.texture;
    b.ramp = form.ramp;
    b.tile = form.tile == 0 ? 0 : 32u << form.tile;
    b.order = order_names[form.order];
    b.nodata = form.nodata == 0 ? "" : nodata_names[form.nodata];
    b.rules = form.rules;
    if (!b.rules.empty()) b.control = control_names[form.control];
    b.horizons = form.horizons == 0 ? "" : horizon_names[form.horizons];
    b.encoding = form.encoding == 0 ? "" : encoding_names[form.encoding];
    b.bbox = form.bbox;
    b.voids = form.voids;
    b.crs = form.crs;
    b.spacing_m = form.spacing_m;
    b.height_scale = form.height_scale;
    b.height_offset_m = form.height_offset_m;
    return b;
}

// A field that is missing or wrong is amber, until it is seen to be right.
class Marked {
public:
    Marked(const BakeDraft& draft, BakeField field)
        : on_(field != BakeField::none && !draft.looking && draft.facts.at == field) {
        if (field == BakeField::output) on_ = !draft.output_problem.empty();
        if (on_) ImGui::PushStyleColor(ImGuiCol_FrameBg, marked);
    }
    ~Marked() {
        if (on_) ImGui::PopStyleColor();
    }
    Marked(const Marked&) = delete;
    Marked& operator=(const Marked&) = delete;
    [[nodiscard]] bool on() const { return on_; }

private:
    bool on_;
};

float width_of_button(const char* text) {
    return ImGui::CalcTextSize(text).x + 2 * ImGui::GetStyle().FramePadding.x + ImGui::GetStyle().ItemSpacing.x;
}

// "browse.spacing" and the like, behind a field.
bool side_button(const char* text, const char* mark, BakeField field, const char* about) {
    ImGui::SameLine();
    ImGui::PushID(static_cast<int>(field));
    ImGui::PushID(mark);
    const bool pressed = ImGui::Button(text);
    ImGui::PopID();
    ImGui::PopID();
    ui::mark(mark, bake_field_names[static_cast<int>(field)]);
    if (about != nullptr) ui::tip(about);
    return pressed;
}

// The value that was proposed for the field, behind it.
bool draw_proposal(const BakeDraft& draft, BakeField field) {
    const HeightFacts& f = draft.facts;
    if (draft.looking || f.at != field || f.proposed.empty()) return false;
    char text[48];
    (void)std::snprintf(text, sizeof text, strings::bake::use, f.proposed.c_str());
    return side_button(text, "propose", field,
                       f.because.empty() ? strings::bake::what_the_line_below_says : f.because.c_str());
}

float proposal_room(const BakeDraft& draft, BakeField field) {
    const HeightFacts& f = draft.facts;
    if (draft.looking || f.at != field || f.proposed.empty()) return 0;
    char text[48];
    (void)std::snprintf(text, sizeof text, strings::bake::use, f.proposed.c_str());
    return width_of_button(text);
}

void begin_row(const char* label, float room) {
    fields::label(label);
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 0.3F - room);
}

void browse(BakeForm& form, BakeField field, bool another, const char* beside, Commands& commands) {
    constexpr FileFilter filters[] = {FileFilter::everything, FileFilter::heights, FileFilter::packs,
                                      FileFilter::images,     FileFilter::ramps,   FileFilter::rules};
    form.browsing = field;
    form.browsing_another = another;
    commands.push(BrowseFor{filters[static_cast<std::size_t>(field)], beside});
}

// True: it was edited.
bool path_field(const char* label, BakeForm& form, BakeField field, fields::PathText& text, const char* hint,
                const char* about, const State& state, Commands& commands) {
    const bool heights = field == BakeField::heights;
    const float room = width_of_button(strings::bake::browse) + (heights ? width_of_button(strings::common::add) : 0);
    begin_row(label, room);
    const char* const name = heights ? "input" : bake_field_names[static_cast<int>(field)];
    bool edited = false;
    {
        const Marked warn(state.bake, field);
        ImGui::PushID(name);
        edited = ImGui::InputTextWithHint("##path", hint, text, fields::path_bytes);
        ImGui::PopID();
    }
    ui::mark("bake", name);
    ui::tip(about);
    const char* const beside = text[0] != '\0' ? text : form.input;
    if (side_button(strings::bake::browse, "browse", field, nullptr)) browse(form, field, false, beside, commands);
    if (heights && side_button(strings::common::add, "add", field, strings::bake::one_more_file_beside_it))
        browse(form, field, text[0] != '\0', beside, commands);
    return edited;
}

void number_field(const char* label, BakeField field, const char* name, double& value, const char* about,
                  const State& state) {
    begin_row(label, proposal_room(state.bake, field));
    {
        const Marked warn(state.bake, field);
        ImGui::PushID(name);
        ImGui::InputDouble("##number", &value, 0, 0, "%.6g");
        ImGui::PopID();
    }
    ui::mark("bake", name);
    ui::tip(about);
    if (draw_proposal(state.bake, field)) value = std::strtod(state.bake.facts.proposed.c_str(), nullptr);
}

void draw_more_heights(BakeForm& form) {
    for (std::size_t i = 0; i < form.more.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        begin_row("", width_of_button(strings::common::remove));
        const std::string& file = form.more[i];
        const std::size_t slash = file.rfind('/');
        ImGui::TextUnformatted(file.c_str() + (slash == std::string::npos ? 0 : slash + 1));
        ui::tip(file.c_str());
        ImGui::SameLine(ImGui::GetContentRegionMax().x - width_of_button(strings::common::remove));
        const bool gone = ImGui::SmallButton(strings::common::remove);
        ImGui::PopID();
        if (gone) {
            form.more.erase(form.more.begin() + static_cast<std::ptrdiff_t>(i));
            return;
        }
    }
}

void text_row(const char* label, BakeField field, fields::PathText& text, const char* hint, const char* about,
              const State& state) {
    begin_row(label, proposal_room(state.bake, field));
    const char* const name = bake_field_names[static_cast<int>(field)];
    {
        const Marked warn(state.bake, field);
        ImGui::PushID(name);
        ImGui::InputTextWithHint("##text", hint, text, fields::path_bytes);
        ImGui::PopID();
    }
    ui::mark("bake", name);
    ui::tip(about);
}

void draw_options(BakeForm& form, const State& state) {
    const BakeField at = state.bake.looking ? BakeField::none : state.bake.facts.at;
    // What has to be decided is seen.
    if (at == BakeField::nodata || at == BakeField::voids || at == BakeField::crs || at == BakeField::encoding ||
        at == BakeField::bbox)
        ImGui::SetNextItemOpen(true, ImGuiCond_Always);
    const bool open = ImGui::TreeNodeEx(strings::bake::more_options, ImGuiTreeNodeFlags_NoTreePushOnOpen);
    ui::mark("bake", "more");
    if (!open) return;
    begin_row(strings::bake::no_data, proposal_room(state.bake, BakeField::nodata));
    {
        const Marked warn(state.bake, BakeField::nodata);
        ImGui::Combo("##nodata", &form.nodata, nodata_names, static_cast<int>(std::size(nodata_names)));
    }
    ui::mark("bake", "nodata");
    ui::tip(strings::bake::samples_without_a_height_a);
    if (draw_proposal(state.bake, BakeField::nodata)) form.nodata = 1;
    text_row(strings::bake::voids, BakeField::voids, form.voids, strings::bake::what_the_file_marks,
             strings::bake::numbers_that_stand_for_no, state);
    if (draw_proposal(state.bake, BakeField::voids)) fields::copy(form.voids, state.bake.facts.proposed);
    text_row(strings::bake::crs, BakeField::crs, form.crs, strings::bake::the_files_own_degrees_become,
             strings::bake::another_coordinate_reference_system_to, state);
    text_row(strings::bake::extract, BakeField::bbox, form.bbox, strings::bake::all_of_it,
             strings::bake::only_what_lies_in_it, state);
    {
        const Marked warn(state.bake, BakeField::encoding);
        fields::choice(strings::bake::encoding, "bake", "encoding", form.encoding, encoding_names,
                       static_cast<int>(std::size(encoding_names)), strings::bake::heights_in_three_colours);
    }
    fields::choice(strings::bake::tile, "bake", "tile", form.tile, tile_names, static_cast<int>(std::size(tile_names)),
                   strings::bake::cells_along_a_side_of);
    fields::choice(strings::bake::order, "bake", "order", form.order, order_names,
                   static_cast<int>(std::size(order_names)), strings::bake::order_of_vertices_in_a);
}

void draw_form(BakeForm& form, const State& state, Commands& commands) {
    ui::focus_first();
    (void)path_field(strings::common::heights, form, BakeField::heights, form.input, strings::bake::a_file_or_drop_one,
                     strings::bake::geotiff_png_bmp_ascii_grid, state, commands);
    draw_more_heights(form);
    if (path_field(strings::bake::pack, form, BakeField::output, form.output,
                   strings::bake::beside_the_heights_with_fjell, strings::bake::where_the_pack_is_written, state,
                   commands))
        form.output_is_chosen = form.output[0] != '\0';
    number_field(strings::bake::spacing_m, BakeField::spacing, "spacing", form.spacing_m,
                 strings::bake::metres_between_samples_0_the, state);
    number_field(strings::bake::height_scale, BakeField::height_scale, "zscale", form.height_scale,
                 strings::bake::multiplies_heights_0_3048_converts, state);
    number_field(strings::bake::height_offset_m, BakeField::none, "zoffset", form.height_offset_m,
                 strings::bake::added_to_heights_after_the, state);
    (void)path_field(strings::bake::texture, form, BakeField::texture, form.texture, strings::common::none,
                     strings::bake::an_ortho_image_placed_by, state, commands);
    (void)path_field(strings::bake::ramp, form, BakeField::ramp, form.ramp, strings::bake::by_height_from_meadows_to,
                     strings::bake::colours_by_height_and_slope, state, commands);
    (void)path_field(strings::bake::rules, form, BakeField::rules, form.rules, strings::common::none,
                     strings::bake::which_materials_lie_where, state, commands);
    ImGui::BeginDisabled(form.rules[0] == '\0');
    fields::choice(strings::bake::control_maps, "bake", "control", form.control, control_names,
                   static_cast<int>(std::size(control_names)), strings::bake::texels_of_the_maps_of);
    ImGui::EndDisabled();
    fields::choice(strings::bake::horizons, "bake", "horizons", form.horizons, horizon_names,
                   static_cast<int>(std::size(horizon_names)), strings::bake::maps_for_shadows_at_any);
    draw_options(form, state);
}

void draw_strip(const HeightFacts& f) {
    const float em = ImGui::GetFontSize();
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, high = 0.6F * em;
    for (std::size_t i = 0; i < ramp_strip; ++i) {
        const float x0 = from.x + width * static_cast<float>(i) / ramp_strip;
        const float x1 = from.x + width * static_cast<float>(i + 1) / ramp_strip;
        ImGui::GetWindowDrawList()->AddRectFilled({x0, from.y}, {x1, from.y + high}, ui::colour(f.strip[i]));
    }
    ImGui::Dummy({width, high});
    ui::tip(strings::bake::the_ramps_colours_from_the);
}

// As large as there is room for it; the room is there before it is.
void draw_pictures(const BakeDraft& draft) {
    const float room = ImGui::GetContentRegionAvail().x, most = picture_em * ImGui::GetFontSize();
    const float top = ImGui::GetCursorPosY();
    const HeightFacts& f = draft.facts;
    if (draft.texture != 0) {
        const auto w = static_cast<float>(f.width_px), h = static_cast<float>(f.height_px);
        const float scale = std::min(room / w, most / h);
        ImGui::Image(reinterpret_cast<ImTextureID>(std::uintptr_t{draft.texture}), {w * scale, h * scale});
        ui::mark("bake", "picture");
        ui::tip(f.image_px != 0 ? strings::bake::the_heights_in_the_colours
                                : strings::bake::the_heights_in_the_colours_that);
    }
    ImGui::SetCursorPosY(top + most + ImGui::GetStyle().ItemSpacing.y);
}

// "label   value", the value on the right.
void fact(const char* label, const char* format, ...) IM_FMTARGS(2);
void fact(const char* label, const char* format, ...) {
    char value[96];
    va_list arguments;
    va_start(arguments, format);
    (void)std::vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    ImGui::TextUnformatted(label);
    ImGui::SameLine();
    const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(value).x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(room, 0.0F));
    ImGui::TextUnformatted(value);
}

// What the rules lay, the most first, in the picture's colours.
void draw_layers(const HeightFacts& f) {
    if (f.rules == 0) return;
    constexpr std::size_t most = 5;
    fact(strings::bake::rules, strings::bake::rules_materials, f.rules, f.layers.size());
    for (std::size_t i = 0; i < std::min(f.layers.size(), most); ++i) {
        ui::swatch(ui::colour(f.layers[i].rgb));
        fact(f.layers[i].name.c_str(), "%s%.0f%%", strings::bake::about, 100 * f.layers[i].share);
    }
    double rest = 0;
    for (std::size_t i = most; i < f.layers.size(); ++i) rest += f.layers[i].share;
    if (f.layers.size() > most) fact(strings::bake::others, "%s%.0f%%", strings::bake::about, 100 * rest);
    if (f.bare_share >= 0.005)
        fact(strings::bake::without_a_material, "%s%.0f%%", strings::bake::about, 100 * f.bare_share);
}

void draw_facts(const BakeDraft& draft) {
    draw_pictures(draft);
    const HeightFacts& f = draft.facts;
    if (!f.known) {
        ImGui::PushTextWrapPos(0);
        ImGui::TextDisabled("%s", draft.looking ? strings::bake::looking_at_the_heights
                                                : strings::bake::size_heights_and_coordinates_of);
        ImGui::PopTextWrapPos();
        return;
    }
    draw_strip(f);
    const char* const about = f.all_read ? "" : strings::bake::about;
    fact(strings::common::heights, strings::bake::to_m, about, metre_text(f.least_m).text, metre_text(f.most_m).text);
    fact(strings::bake::samples, "%s x %s", grouped(f.columns).c_str(), grouped(f.rows).c_str());
    if (f.has_spacing) {
        if (f.spacing_m[0] == f.spacing_m[1])
            fact(strings::bake::spacing, "%.4g m", f.spacing_m[0]);
        else
            fact(strings::bake::spacing, "%.4g x %.4g m", f.spacing_m[0], f.spacing_m[1]);
        fact(strings::bake::extents, "%s x %s m", metre_text((f.columns - 1) * f.spacing_m[0]).text,
             metre_text((f.rows - 1) * f.spacing_m[1]).text);
    } else { // the rows are there already, or a click that takes what is proposed would move the buttons
        fact(strings::bake::spacing, "-");
        fact(strings::bake::extents, "-");
    }
    fact(strings::bake::no_data, "%s%.3g%%", about, 100 * f.void_share);
    if (!f.image.empty()) fact(strings::bake::texture, "%s", f.image.c_str());
    draw_layers(f);
    ImGui::PushTextWrapPos(0);
    if (!f.unit_named) ImGui::TextColored(ImColor(ui::quiet).Value, strings::bake::no_unit_is_named_1);
    ImGui::TextColored(ImColor(ui::quiet).Value, "%s%s%s",
                       f.crs.empty() ? strings::bake::no_coordinate_reference_system : f.crs.c_str(),
                       f.reprojected_from.empty() ? "" : strings::bake::reprojected_from, f.reprojected_from.c_str());
    ImGui::PopTextWrapPos();
}

const char* name_in(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    return path.c_str() + (slash == std::string::npos ? 0 : slash + 1);
}

// What control maps and horizons add to the pack, a sample.
double maps_bytes(const BakePack& b) {
    double bytes = 0;
    if (!b.rules.empty()) bytes += control_bytes[index_of_name(b.control, control_names, std::size(control_names))];
    if (!b.horizons.empty()) bytes += horizon_bytes[index_of_name(b.horizons, horizon_names, std::size(horizon_names))];
    return bytes;
}

double seconds_a_sample(const BakeDraft& d) {
    const BakePack& b = d.pack;
    double seconds = 1 / (d.facts.reprojected_from.empty() ? samples_a_second : warped_a_second);
    if (!b.rules.empty())
        seconds += 1 / control_a_second[index_of_name(b.control, control_names, std::size(control_names))];
    if (!b.horizons.empty())
        seconds += 1 / horizons_a_second[index_of_name(b.horizons, horizon_names, std::size(horizon_names))];
    return seconds;
}

// In words: what is in the way or, where nothing is, what the button does.
void draw_plan(const State& state) {
    const BakeDraft& d = state.bake;
    const HeightFacts& f = d.facts;
    ImGui::PushTextWrapPos(0);
    if (d.looking) {
        ImGui::TextDisabled(strings::bake::looking_at_the_files);
    } else if (d.pack.inputs.empty()) {
        ImGui::TextDisabled(strings::bake::choose_a_file_of_heights);
    } else if (!f.problem.empty() || !d.output_problem.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
        if (f.problem.empty())
            ImGui::TextUnformatted(d.output_problem.c_str());
        else if (f.proposed.empty() || f.because.empty())
            ImGui::TextUnformatted(f.problem.c_str());
        else
            ImGui::Text(strings::bake::proposed, f.problem.c_str(), f.proposed.c_str(), f.because.c_str());
        ImGui::PopStyleColor();
    } else {
        const double samples = static_cast<double>(f.columns) * f.rows;
        const double seconds = samples * seconds_a_sample(d);
        char time[48];
        if (seconds > 8)
            (void)std::snprintf(time, sizeof time, strings::bake::about_time, seconds < 90 ? seconds : seconds / 60,
                                seconds < 90 ? strings::bake::seconds : strings::bake::minutes);
        else
            (void)std::snprintf(time, sizeof time, strings::bake::some_seconds);
        ImGui::Text(strings::bake::writes_to_in_while_you, name_in(d.pack.output),
                    byte_text(samples * (bytes_a_sample[0] + maps_bytes(d.pack))).text,
                    byte_text(samples * (bytes_a_sample[1] + maps_bytes(d.pack))).text, time,
                    d.output_exists ? strings::bake::a_pack_of_that_name : "",
                    state.scene.open() ? strings::bake::when_it_is_done_you : strings::bake::then_it_is_opened,
                    state.scene.open() ? name_in(state.scene.path) : "", state.scene.open() ? "." : "");
    }
    ImGui::PopTextWrapPos();
    ui::mark("bake", "plan");
}

void draw_browser(BakeForm& form, const State& state, Commands& commands) {
    if (form.browsing == BakeField::none) return;
    constexpr const char* title = strings::bake::choose_a_file;
    if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
    const float em = ImGui::GetFontSize();
    const keyboard::TabStops no_title(false); // its list brings its own
    const ImVec2 display = ImGui::GetIO().DisplaySize, from = ImGui::GetWindowPos();
    ImGui::SetNextWindowPos({std::min(from.x + 2 * em, 0.1F * display.x), from.y + 2 * em}, ImGuiCond_Appearing);
    ImGui::SetNextWindowSize({std::min(44 * em, 0.9F * display.x), std::min(30 * em, display.y - from.y - 3 * em)});
    bool open = true;
    if (!ImGui::BeginPopupModal(title, &open, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) return;
    form.browser.nested = true;
    const bool output = form.browsing == BakeField::output;
    begin_file_browser(form.browser, state, output ? name_in(state.bake.pack.output) : "");
    const bool chosen = [&] { // ImGui wants what is pushed within a window popped within it
        const keyboard::TabStops stops;
        return draw_file_browser(state, commands, form.browser, strings::bake::choose);
    }();
    if (chosen) {
        commands.push(
            GiveBakeFile{state.files.browser.path_of(form.browser.name), form.browsing, form.browsing_another});
        open = false;
    }
    if (!open || form.browser.cancelled || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false)) {
        form.browsing = BakeField::none;
        form.browser = {};
        ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
}

void start(BakeForm& form, const State& state, Commands& commands) {
    BakePack bake = bake_of(form);
    bake.asks = state.scene.open();
    commands.push(std::move(bake));
}

} // namespace

void draw_bake(const State& state, Commands& commands) {
    static BakeForm form;
    const BakeDraft& draft = state.bake;
    if (form.given != draft.given) load(form, draft);
    if (!form.output_is_chosen && draft.pack.output != form.output) {
        fields::copy(form.output, draft.pack.output);
        form.sent.output = draft.pack.output;
    }
    if (ImGui::BeginTable("bake", 2, ImGuiTableFlags_None)) {
        ImGui::TableSetupColumn("form", ImGuiTableColumnFlags_WidthStretch, 1.7F);
        ImGui::TableSetupColumn("facts", ImGuiTableColumnFlags_WidthStretch, 1);
        ImGui::TableNextColumn();
        draw_form(form, state, commands);
        ImGui::TableNextColumn();
        draw_facts(draft);
        ImGui::EndTable();
    }
    if (BakePack now = bake_of(form); !(now == form.sent)) {
        form.sent = now;
        commands.push(DraftBake{std::move(now), form.output_is_chosen});
    }
    ImGui::Separator();
    // The buttons stay where they are, whatever is said.
    const float top = ImGui::GetCursorPosY();
    draw_plan(state);
    ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), top + 3.4F * ImGui::GetTextLineHeightWithSpacing()));
    const bool can = !state.job.running && form.input[0] != '\0' && draft.output_problem.empty() &&
                     (draft.looking || draft.facts.problem.empty());
    if (fields::button(strings::common::bake, "bake", "start", can, strings::bake::bakes_in_the_background_with,
                       true)) {
        if (draft.output_exists) {
            (void)std::snprintf(form.overwrite.name, sizeof form.overwrite.name, "%.500s", name_in(form.output));
            form.overwrite.asks = true;
        } else {
            start(form, state, commands);
        }
    }
    fields::close("bake", commands);
    if (fields::runs(state, JobKind::bake)) fields::cancel("bake", commands);
    fields::outcome(state, JobKind::bake, true);
    if (draw_overwrite(form.overwrite)) start(form, state, commands);
    draw_browser(form, state, commands);
}

void draw_baked(const State& state, Commands& commands) {
    ImGui::TextWrapped(strings::bake::is_baked_fly_it_and, name_in(state.bake.ready), name_in(state.scene.path));
    ImGui::Spacing();
    if (ui::button(strings::bake::fly_it, true)) commands.push(OpenBaked{true});
    ui::mark("baked", "open");
    ImGui::SameLine();
    if (ui::button(strings::bake::not_now)) commands.push(OpenBaked{false});
    ui::mark("baked", "stay");
    ui::tip(strings::bake::it_stays_on_the_disk);
}

} // namespace fjell::editor
