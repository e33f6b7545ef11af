// The form of the dialog that bakes: what is read and written.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>

#include "editor/panels/bake_form.h"

namespace fjell::editor::bake_dialog {

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

void load(Form& form, const BakeDraft& draft) {
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
    form.control = b.control.empty() ? usual_control : static_cast<int>(index_of(b.control, control_names));
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

BakePack pack_of(const Form& form) {
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
                       f.because.empty() ? "Takes what the line below proposes." : f.because.c_str());
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

void browse(Form& form, BakeField field, bool another, const char* beside, Commands& commands) {
    constexpr FileFilter filters[] = {FileFilter::everything, FileFilter::heights, FileFilter::packs,
                                      FileFilter::images,     FileFilter::ramps,   FileFilter::rules};
    form.browsing = field;
    form.browsing_another = another;
    commands.push(BrowseFor{filters[static_cast<std::size_t>(field)], beside});
}

// True: it was edited.
bool path_field(const char* label, Form& form, BakeField field, fields::PathText& text, const char* hint,
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
    ui::mark("bake", name);
    ui::tip(about);
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
    ui::mark("bake", name);
    ui::tip(about);
    if (draw_proposal(state.bake, field)) value = std::strtod(state.bake.facts.proposed.c_str(), nullptr);
}

void draw_more_heights(Form& form) {
    for (std::size_t i = 0; i < form.more.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        begin_row("", width_of_button("Remove"));
        const std::string& file = form.more[i];
        const std::size_t slash = file.rfind('/');
        ImGui::TextUnformatted(file.c_str() + (slash == std::string::npos ? 0 : slash + 1));
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
    ui::mark("bake", name);
    ui::tip(about);
}

void draw_options(Form& form, const State& state) {
    const BakeField at = state.bake.looking ? BakeField::none : state.bake.facts.at;
    // What has to be decided is seen.
    if (at == BakeField::nodata || at == BakeField::voids || at == BakeField::crs || at == BakeField::encoding ||
        at == BakeField::bbox)
        ImGui::SetNextItemOpen(true, ImGuiCond_Always);
    const bool open = ImGui::TreeNodeEx("More options", ImGuiTreeNodeFlags_NoTreePushOnOpen);
    ui::mark("bake", "more");
    if (!open) return;
    begin_row("No data", proposal_room(state.bake, BakeField::nodata));
    {
        const Marked warn(state.bake, BakeField::nodata);
        ImGui::Combo("##nodata", &form.nodata, nodata_names, static_cast<int>(std::size(nodata_names)));
    }
    ui::mark("bake", "nodata");
    ui::tip("What becomes of samples without a height: they stay a hole, are filled from their neighbours, or are "
            "refused.");
    if (draw_proposal(state.bake, BakeField::nodata)) form.nodata = 1;
    text_row("Voids", BakeField::voids, form.voids, "what the file marks",
             "Numbers that mean \"no height\" although the file does not say so, such as -9999; separate several by "
             "commas. none: every number that the file does not mark is a height.",
             state);
    if (draw_proposal(state.bake, BakeField::voids)) fields::copy(form.voids, state.bake.facts.proposed);
    text_row("CRS", BakeField::crs, form.crs, "the file's own; degrees become UTM",
             "The coordinate reference system to reproject to, such as EPSG:25832. none: nothing is reprojected.",
             state);
    text_row("Extract", BakeField::bbox, form.bbox, "all of it",
             "Only what lies within west,south,east,north: units of the CRS after reprojection, or columns and rows "
             "from the north-west where there are no coordinates.",
             state);
    {
        const Marked warn(state.bake, BakeField::encoding);
        fields::choice("Encoding", "bake", "encoding", form.encoding, encoding_names,
                       static_cast<int>(std::size(encoding_names)),
                       "How heights are packed into red, green and blue: terrarium or terrain-rgb (Mapbox). none: one "
                       "band of heights.");
    }
    fields::choice("Tile", "bake", "tile", form.tile, tile_names, static_cast<int>(std::size(tile_names)),
                   "Cells along a side of a tile, the unit of drawing. Smaller tiles are culled more tightly and cost "
                   "more draw calls; auto chooses 512, or what suits the extents.");
    fields::choice("Order", "bake", "order", form.order, order_names, static_cast<int>(std::size(order_names)),
                   "Order of the vertices in a page: planar and hz (hierarchical Z) suit both methods; linear, as in "
                   "the thesis, suits the recursive method alone.");
}

} // namespace

void draw_form(Form& form, const State& state, Commands& commands) {
    ui::focus_first();
    (void)path_field("Heights", form, BakeField::heights, form.input, "a file, or drop one here",
                     "GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM, netCDF, VRT; or a recipe (.json).", state,
                     commands);
    draw_more_heights(form);
    if (path_field(
            "Pack", form, BakeField::output, form.output, "beside the heights, with .fjell",
            "Where the pack is written. An existing one is replaced once you have agreed and the bake is complete.",
            state, commands))
        form.output_is_chosen = form.output[0] != '\0';
    number_field("Spacing, m", BakeField::spacing, "spacing", form.spacing_m,
                 "Metres between samples. 0: the file's own. Needed where the file has no coordinates.", state);
    number_field("Height scale", BakeField::height_scale, "zscale", form.height_scale,
                 "Multiplies heights: 0.3048 converts feet to metres. 1: as the file has them.", state);
    number_field("Height offset, m", BakeField::none, "zoffset", form.height_offset_m,
                 "Added to heights, after the scale.", state);
    (void)path_field("Texture", form, BakeField::texture, form.texture, "none",
                     "An ortho-image, placed by its coordinates, or stretched over the terrain where it has none.",
                     state, commands);
    (void)path_field("Ramp", form, BakeField::ramp, form.ramp, "by height, from meadows to snow",
                     "Colours by height and slope where there is no image (JSON, as in content/ramps).", state,
                     commands);
    (void)path_field("Rules", form, BakeField::rules, form.rules, "none",
                     "Rules for control maps: which materials lie where, by height, slope, curvature, aspect, wetness "
                     "and noise, by rasters and paint (JSON, as in content/materials/control).",
                     state, commands);
    ImGui::BeginDisabled(form.rules[0] == '\0');
    fields::choice("Control maps", "bake", "control", form.control, control_names,
                   static_cast<int>(std::size(control_names)),
                   "How fine the rules' control maps are: full has a texel for each sample, half one for 2 x 2 "
                   "samples, quarter one for 4 x 4.");
    ImGui::EndDisabled();
    fields::choice(
        "Horizons", "bake", "horizons", form.horizons, horizon_names, static_cast<int>(std::size(horizon_names)),
        "Horizon maps, for shadows at any time of day: half has a texel for 2 x 2 samples, quarter one for 4 x 4.");
    draw_options(form, state);
}

} // namespace fjell::editor::bake_dialog
