// The dialog that bakes: its form on the left, on the right what was found in the files, and below what will happen;
// the file browser over it; and the question that a pack asks when it is ready.
#include <algorithm>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "editor/number_text.h"
#include "editor/panels/forms.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "editor/panels/ui.h"

namespace fjell::editor::bake_dialog {

// Words of fjell-bake, in the order in which the form lists them.
inline constexpr const char* splat_names[] = {"full", "half", "quarter"};
inline constexpr const char* horizon_names[] = {"none", "half", "quarter"};
inline constexpr int usual_splat = 1; // fjell-bake's default
// 0 where the name is none of them.
[[nodiscard]] std::size_t index_of(const std::string& name, std::span<const char* const> names);

namespace {

constexpr const char* tile_names[] = {"auto", "64", "128", "256", "512", "1024", "2048"};
constexpr const char* order_names[] = {"planar", "hz", "linear"};
constexpr const char* nodata_names[] = {"auto: holes; suspicious values are refused", "hole", "fill", "refuse"};
constexpr const char* encoding_names[] = {"none", "terrarium", "terrain-rgb"};
constexpr ImU32 marked = IM_COL32(104, 80, 24, 255);

} // namespace

std::size_t index_of(const std::string& name, std::span<const char* const> names) {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? 0 : static_cast<std::size_t>(found - names.begin());
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
    fields::copy(form.band, b.band);
    fields::copy(form.size, b.size);
    fields::copy(form.vertical_unit, b.vertical_unit);
    fields::copy(form.texture_bands, b.texture_bands);
    form.splat = b.splat.empty() ? usual_splat : static_cast<int>(index_of(b.splat, splat_names));
    form.horizons = static_cast<int>(index_of(b.horizons, horizon_names));
    form.encoding = static_cast<int>(index_of(b.encoding, encoding_names));
    fields::copy(form.voids, b.voids);
    fields::copy(form.crs, b.crs);
    form.tile = b.tile == 0 ? 0 : static_cast<int>(index_of(std::to_string(b.tile), tile_names));
    form.order = static_cast<int>(index_of(b.order, order_names));
    form.nodata = static_cast<int>(index_of(b.nodata, nodata_names));
    form.spacing_m = b.spacing_m;
    form.height_scale = b.height_scale;
    form.height_offset_m = b.height_offset_m;
    form.sent = b;
}

BakePack pack_of(const BakeForm& form) {
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
    if (!b.rules.empty()) b.splat = splat_names[form.splat];
    b.horizons = form.horizons == 0 ? "" : horizon_names[form.horizons];
    b.encoding = form.encoding == 0 ? "" : encoding_names[form.encoding];
    b.bbox = form.bbox;
    b.band = form.band;
    b.size = form.size;
    b.vertical_unit = form.vertical_unit;
    b.texture_bands = form.texture_bands;
    b.voids = form.voids;
    b.crs = form.crs;
    b.spacing_m = form.spacing_m;
    b.height_scale = form.height_scale;
    b.height_offset_m = form.height_offset_m;
    return b;
}

namespace {

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
    (void)std::snprintf(text, sizeof text, "Use %.32s", f.proposed.c_str());
    return side_button(text, "propose", field,
                       f.because.empty() ? "Uses the value that is proposed below." : f.because.c_str());
}

float proposal_room(const BakeDraft& draft, BakeField field) {
    const HeightFacts& f = draft.facts;
    if (draft.looking || f.at != field || f.proposed.empty()) return 0;
    char text[48];
    (void)std::snprintf(text, sizeof text, "Use %.32s", f.proposed.c_str());
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
    const float room = width_of_button("Browse") + (heights ? width_of_button("Add") : 0);
    begin_row(label, room);
    const char* const name = heights ? "input" : bake_field_names[static_cast<int>(field)];
    bool edited = false;
    {
        const Marked warn(state.bake, field);
        ImGui::PushID(name);
        edited = ImGui::InputTextWithHint("##path", hint, text, fields::path_bytes);
        ImGui::PopID();
    }
    ui::control("bake", name, about);
    const char* const beside = text[0] != '\0' ? text : form.input;
    if (side_button("Browse", "browse", field, nullptr)) browse(form, field, false, beside, commands);
    if (heights && side_button("Add", "add", field, "Adds a file: several make a mosaic."))
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
    ui::control("bake", name, about);
    if (draw_proposal(state.bake, field)) value = std::strtod(state.bake.facts.proposed.c_str(), nullptr);
}

void draw_more_heights(BakeForm& form) {
    for (std::size_t i = 0; i < form.more.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        begin_row("", width_of_button("Remove"));
        const std::string& file = form.more[i];
        ImGui::TextUnformatted(file_name(file));
        ui::tip(file.c_str());
        ImGui::SameLine(ImGui::GetContentRegionMax().x - width_of_button("Remove"));
        const bool gone = ImGui::SmallButton("Remove");
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
    ui::control("bake", name, about);
}

void draw_options(BakeForm& form, const State& state) {
    const BakeField at = state.bake.looking ? BakeField::none : state.bake.facts.at;
    // What has to be decided is seen.
    if (at == BakeField::nodata || at == BakeField::voids || at == BakeField::crs || at == BakeField::encoding ||
        at == BakeField::bbox || at == BakeField::band || at == BakeField::size || at == BakeField::vertical_unit ||
        at == BakeField::texture_bands)
        ImGui::SetNextItemOpen(true, ImGuiCond_Always);
    const bool open = ImGui::TreeNodeEx("More options", ImGuiTreeNodeFlags_NoTreePushOnOpen);
    ui::mark("bake", "more");
    if (!open) return;
    begin_row("No data", proposal_room(state.bake, BakeField::nodata));
    {
        const Marked warn(state.bake, BakeField::nodata);
        ImGui::Combo("##nodata", &form.nodata, nodata_names, static_cast<int>(std::size(nodata_names)));
    }
    ui::control("bake", "nodata",
                "Samples without a height: they become holes, are filled from their neighbours, or are "
                "refused.");
    if (draw_proposal(state.bake, BakeField::nodata)) form.nodata = 1;
    text_row("Voids", BakeField::voids, form.voids, "what the file marks",
             "Numbers that mean \"no height\" although the file does not mark them, such as -9999. Separate several by "
             "commas. With none, every number that the file does not mark is a height.",
             state);
    if (draw_proposal(state.bake, BakeField::voids)) fields::copy(form.voids, state.bake.facts.proposed);
    text_row("CRS", BakeField::crs, form.crs, "the file's own; degrees become UTM",
             "The coordinate reference system to reproject to, such as EPSG:25832. With none, nothing is reprojected.",
             state);
    text_row("Extract", BakeField::bbox, form.bbox, "all of it",
             "Bakes only the region west,south,east,north: in units of the CRS after reprojection, or in columns and "
             "rows from the north-west if the file has no coordinates.",
             state);
    text_row("Band", BakeField::band, form.band, "the one named as elevation",
             "The band of heights, in a file with several bands: its number, from 1, or its name.", state);
    text_row("Height unit", BakeField::vertical_unit, form.vertical_unit, "as the file says; else metres",
             "The unit of heights that name no unit: m, ft, us-ft, or another of PROJ's names.", state);
    text_row("Raw size", BakeField::size, form.size, "square",
             "Columns and rows of raw numbers (.raw, .r16, .r32), as in 1025x513.", state);
    ImGui::BeginDisabled(form.texture[0] == '\0');
    text_row("Texture bands", BakeField::texture_bands, form.texture_bands, "as the image says",
             "The bands of red, green and blue in an image with several bands, as in 4,3,2, or the band of grey.",
             state);
    ImGui::EndDisabled();
    {
        const Marked warn(state.bake, BakeField::encoding);
        fields::choice(
            "Encoding", "bake", "encoding", form.encoding, encoding_names,
            "How heights are packed into red, green and blue: terrarium or terrain-rgb (Mapbox). With none, the "
            "file has one band of heights.");
    }
    fields::choice(
        "Tile", "bake", "tile", form.tile, tile_names,
        "Cells along a side of a tile. A tile is drawn or culled as a whole. Smaller tiles are culled more tightly and "
        "cost more draw calls; auto chooses 512, or a size that suits the extents.");
    fields::choice("Order", "bake", "order", form.order, order_names,
                   "Order of the vertices in a page: planar and hz (hierarchical Z) suit both methods; linear, as in "
                   "the thesis, suits the recursive method alone.");
}

} // namespace

void draw_form(BakeForm& form, const State& state, Commands& commands) {
    ui::focus_first();
    (void)path_field("Heights", form, BakeField::heights, form.input, "a file, or drop one here",
                     "GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT; or a recipe (.json).", state,
                     commands);
    draw_more_heights(form);
    if (path_field(
            "Pack", form, BakeField::output, form.output, "beside the heights, with .fjell",
            "Where the pack is written. An existing pack is replaced only if you agree, and when the bake is complete.",
            state, commands))
        form.output_is_chosen = form.output[0] != '\0';
    number_field("Spacing, m", BakeField::spacing, "spacing", form.spacing_m,
                 "Metres between samples. 0 takes the file's own. Needed if the file has no coordinates.", state);
    number_field(
        "Height scale", BakeField::height_scale, "zscale", form.height_scale,
        "Multiplies heights: 0.3048 converts feet to metres, and -1 depths to heights. 0 takes the file's own scale. 1 "
        "takes its numbers as metres.",
        state);
    number_field("Height offset, m", BakeField::none, "zoffset", form.height_offset_m,
                 "Added to heights, after the scale.", state);
    (void)path_field(
        "Texture", form, BakeField::texture, form.texture, "none",
        "An ortho-image. It is placed by its coordinates; without coordinates it is stretched over the terrain.", state,
        commands);
    (void)path_field("Ramp", form, BakeField::ramp, form.ramp, "by height, from meadows to snow",
                     "Colours by height and slope, used without an image (JSON, as in content/ramps).", state,
                     commands);
    (void)path_field("Rules", form, BakeField::rules, form.rules, "none",
                     "Rules for splat maps: which materials lie where, by height, slope, curvature, aspect, wetness "
                     "and noise, by rasters and paint (JSON, as in content/materials/splat).",
                     state, commands);
    ImGui::BeginDisabled(form.rules[0] == '\0');
    fields::choice("Splat maps", "bake", "splat", form.splat, splat_names,
                   "How fine the rules' splat maps are: full has a texel for each sample, half one for 2 x 2 "
                   "samples, quarter one for 4 x 4.");
    ImGui::EndDisabled();
    fields::choice(
        "Horizons", "bake", "horizons", form.horizons, horizon_names,
        "Horizon maps, for shadows at any time of day: half has a texel for 2 x 2 samples, quarter one for 4 x 4.");
    draw_options(form, state);
}

// --- What was found in the files that the dialog bakes, in pictures and figures, and below what will happen, in words,
// size and time.

namespace {

constexpr double bytes_a_sample[] = {1.3, 3.0}; // of packs: smooth large fields, rough small ones; with maps
constexpr double samples_a_second = 6e6, warped_a_second = 3e6; // on two cores; about
// What maps add a sample, in the order of their names: docs/notes/horizons.md and materials.md.
constexpr double splat_bytes[] = {9.9, 2.6, 0.7}, splat_a_second[] = {2e6, 6e6, 2e7};
constexpr double horizon_bytes[] = {0, 2.7, 0.7}, horizons_a_second[] = {0, 6e6, 1.3e7};
constexpr float picture_em = 10.5F; // high

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
    ui::tip("The ramp's colours, from the lowest height to the highest.");
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
        ui::control("bake", "picture",
                    f.image_px != 0
                        ? "The heights in the colours of the ramp, and beside them the texture."
                        : "The heights in the colours that the terrain will have; where rules lay materials, "
                          "in the colours of the list below.");
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
    fact("Rules", "%zu, %zu materials", f.rules, f.layers.size());
    for (std::size_t i = 0; i < std::min(f.layers.size(), most); ++i) {
        ui::swatch(ui::colour(f.layers[i].rgb));
        fact(f.layers[i].name.c_str(), "%s%.0f%%", "about ", 100 * f.layers[i].share);
    }
    double rest = 0;
    for (std::size_t i = most; i < f.layers.size(); ++i) rest += f.layers[i].share;
    if (f.layers.size() > most) fact("others", "%s%.0f%%", "about ", 100 * rest);
    if (f.bare_share >= 0.005) fact("without a material", "%s%.0f%%", "about ", 100 * f.bare_share);
}

} // namespace

void draw_facts(const BakeDraft& draft) {
    draw_pictures(draft);
    const HeightFacts& f = draft.facts;
    if (!f.known) {
        ImGui::PushTextWrapPos(0);
        if (draft.looking)
            ImGui::TextDisabled("Reading the heights: %.0f%%", 100 * draft.look_share);
        else
            ImGui::TextDisabled("Size, heights and coordinates of the file are shown here.");
        ImGui::PopTextWrapPos();
        return;
    }
    draw_strip(f);
    const char* const about = f.all_read ? "" : "about ";
    fact("Heights", "%s%s to %s m", about, metre_text(f.least_m).text, metre_text(f.most_m).text);
    fact("Samples", "%s x %s", grouped(f.columns).c_str(), grouped(f.rows).c_str());
    if (f.has_spacing) {
        if (f.spacing_m[0] == f.spacing_m[1])
            fact("Spacing", "%.4g m", f.spacing_m[0]);
        else
            fact("Spacing", "%.4g x %.4g m", f.spacing_m[0], f.spacing_m[1]);
        fact("Extents", "%s x %s m", metre_text((f.columns - 1) * f.spacing_m[0]).text,
             metre_text((f.rows - 1) * f.spacing_m[1]).text);
    } else { // the rows are there already, or a click that takes what is proposed would move the buttons
        fact("Spacing", "-");
        fact("Extents", "-");
    }
    fact("No data", "%s%.3g%%", about, 100 * f.void_share);
    if (!f.image.empty()) fact("Texture", "%s", f.image.c_str());
    draw_layers(f);
    ImGui::PushTextWrapPos(0);
    if (!f.unit_named) ImGui::TextColored(ImColor(ui::quiet).Value, "No unit is named: heights are taken as metres");
    ImGui::TextColored(ImColor(ui::quiet).Value, "%s%s%s",
                       f.crs.empty() ? "No coordinate reference system" : f.crs.c_str(),
                       f.reprojected_from.empty() ? "" : ", reprojected from ", f.reprojected_from.c_str());
    ImGui::PopTextWrapPos();
}

namespace {

// What splat maps and horizons add to the pack, a sample.
double maps_bytes(const BakePack& b) {
    double bytes = 0;
    if (!b.rules.empty()) bytes += splat_bytes[index_of(b.splat, splat_names)];
    if (!b.horizons.empty()) bytes += horizon_bytes[index_of(b.horizons, horizon_names)];
    return bytes;
}

double seconds_a_sample(const BakeDraft& d) {
    const BakePack& b = d.pack;
    double seconds = 1 / (d.facts.reprojected_from.empty() ? samples_a_second : warped_a_second);
    if (!b.rules.empty()) seconds += 1 / splat_a_second[index_of(b.splat, splat_names)];
    if (!b.horizons.empty()) seconds += 1 / horizons_a_second[index_of(b.horizons, horizon_names)];
    return seconds;
}

} // namespace

void draw_plan(const State& state) {
    const BakeDraft& d = state.bake;
    const HeightFacts& f = d.facts;
    ImGui::PushTextWrapPos(0);
    if (d.looking) {
        ImGui::TextDisabled("Reading the files: %.0f%%", 100 * d.look_share);
    } else if (d.pack.inputs.empty()) {
        ImGui::TextDisabled("Choose a file of heights: browse, type, or drop it on the window.");
    } else if (!f.problem.empty() || !d.output_problem.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
        if (f.problem.empty())
            ImGui::TextUnformatted(d.output_problem.c_str());
        else if (f.proposed.empty() || f.because.empty())
            ImGui::TextUnformatted(f.problem.c_str());
        else
            ImGui::Text("%s. Proposed: %s, %s.", f.problem.c_str(), f.proposed.c_str(), f.because.c_str());
        ImGui::PopStyleColor();
    } else {
        const double samples = static_cast<double>(f.columns) * f.rows;
        const double seconds = samples * seconds_a_sample(d);
        char time[48];
        if (seconds > 8)
            (void)std::snprintf(time, sizeof time, "about %.0f %s", seconds < 90 ? seconds : seconds / 60,
                                seconds < 90 ? "seconds" : "minutes");
        else
            (void)std::snprintf(time, sizeof time, "a few seconds");
        ImGui::Text("Writes %s: %s to %s, in %s, in the background.%s %s%s%s", file_name(d.pack.output),
                    byte_text(samples * (bytes_a_sample[0] + maps_bytes(d.pack))).text,
                    byte_text(samples * (bytes_a_sample[1] + maps_bytes(d.pack))).text, time,
                    d.output_exists ? " A pack of that name exists; you are asked before it is replaced." : "",
                    state.scene.open() ? "When it is done, you are asked whether to close " : "Then it is opened.",
                    state.scene.open() ? file_name(state.scene.path) : "", state.scene.open() ? "." : "");
    }
    ImGui::PopTextWrapPos();
    ui::mark("bake", "plan");
}

} // namespace fjell::editor::bake_dialog

// --- The dialog around them.

namespace fjell::editor {

namespace {

void draw_browser(BakeForm& form, const State& state, Commands& commands) {
    if (form.browsing == BakeField::none) return;
    const bool output = form.browsing == BakeField::output;
    const NestedBrowser done =
        draw_nested_browser(state, commands, form.browser, output ? file_name(state.bake.pack.output) : "");
    if (done == NestedBrowser::chose)
        commands.push(
            GiveBakeFile{state.files.browser.path_of(form.browser.name), form.browsing, form.browsing_another});
    if (done == NestedBrowser::open) return;
    form.browsing = BakeField::none;
    form.browser = {};
}

void start(BakeForm& form, const State& state, Commands& commands) {
    BakePack pack = bake_dialog::pack_of(form);
    pack.asks = state.scene.open();
    commands.push(std::move(pack));
}

} // namespace

void draw_bake(const State& state, PanelState& own, Commands& commands) {
    BakeForm& form = own.bake;
    const BakeDraft& draft = state.bake;
    if (form.given != draft.given) bake_dialog::load(form, draft);
    if (!form.output_is_chosen && draft.pack.output != form.output) {
        fields::copy(form.output, draft.pack.output);
        form.sent.output = draft.pack.output;
    }
    if (ImGui::BeginTable("bake", 2, ImGuiTableFlags_None)) {
        ImGui::TableSetupColumn("form", ImGuiTableColumnFlags_WidthStretch, 1.7F);
        ImGui::TableSetupColumn("facts", ImGuiTableColumnFlags_WidthStretch, 1);
        ImGui::TableNextColumn();
        bake_dialog::draw_form(form, state, commands);
        ImGui::TableNextColumn();
        bake_dialog::draw_facts(draft);
        ImGui::EndTable();
    }
    if (BakePack now = bake_dialog::pack_of(form); !(now == form.sent)) {
        form.sent = now;
        commands.push(DraftBake{std::move(now), form.output_is_chosen});
    }
    ImGui::Separator();
    // The buttons stay where they are, whatever is said.
    const float top = ImGui::GetCursorPosY();
    bake_dialog::draw_plan(state);
    ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), top + 3.4F * ImGui::GetTextLineHeightWithSpacing()));
    const bool can = !state.job.running && form.input[0] != '\0' && draft.output_problem.empty() &&
                     (draft.looking || draft.facts.problem.empty());
    if (fields::button("Bake", "bake", "start", can, "Bakes in the background with 512 MB of memory (Enter).", true)) {
        if (draft.output_exists) {
            (void)std::snprintf(form.overwrite.name, sizeof form.overwrite.name, "%.500s", file_name(form.output));
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

void draw_baked(const State& state, PanelState&, Commands& commands) {
    ImGui::TextWrapped("%s is ready. Open it, and close %s?", file_name(state.bake.ready), file_name(state.scene.path));
    ImGui::Spacing();
    if (ui::button("Open it", true)) commands.push(OpenBaked{true});
    ui::mark("baked", "open");
    ImGui::SameLine();
    if (ui::button("Not now")) commands.push(OpenBaked{false});
    ui::control("baked", "stay", "The pack stays on the disk: open it with File > Open.");
}

} // namespace fjell::editor
