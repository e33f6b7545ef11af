#include <algorithm>
#include <cstdio>
#include <cstring>

#include <imgui_internal.h> // a menu that stays open

#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr double threshold_step = 1.25;
constexpr double column_step_px = 24, split_step = 0.05;

void item(const char* name, const char* label, const char* keys, bool enabled, Commands& commands, Command command) {
    if (ImGui::MenuItem(label, keys, false, enabled)) commands.push(std::move(command));
    ui::mark("menu", name);
}

void save(const State& state, Commands& commands) {
    if (state.document.path().empty())
        commands.push(ShowDialog{Dialog::save_profile});
    else
        commands.push(SaveProfile{});
}

void change_threshold(const State& state, double factor, Commands& commands) {
    static const ProfileKey* const key = find_profile_key("refine.max_error_px");
    const double value = key->get(state.document.profile()) * factor;
    commands.push(SetKey{key, std::clamp(value, key->least, key->most), false});
}

namespace key {
constexpr int escape = 256, tab = 258, f10 = 299, f11 = 300;
}

// ImGui 1.86 knows most letters by the window system's number only, GLFW's are those of ASCII.
bool pressed(int key, bool repeat) {
    return ImGui::IsKeyPressed(key, repeat);
}

// Keys that belong to the window rather than to the profile.
void window_keys(const State& state, Commands& commands) {
    const Interface& i = state.interface;
    if (pressed(key::tab, false) && !i.panel_keys && i.dialog != Dialog::start)
        commands.push(SetSwitch{Switch::show_panels, !i.arrangement.panels});
    if (pressed(key::f11, false)) commands.push(SetSwitch{Switch::picture_only, !i.picture_only});
    if (pressed(key::escape, false) && i.dialog == Dialog::none && !ImGui::IsAnyItemActive()) {
        if (i.picture_only)
            commands.push(SetSwitch{Switch::picture_only, false});
        else if (state.probe.on)
            commands.push(SetSwitch{Switch::probe, false});
        if (i.panel_keys) commands.push(SetSwitch{Switch::panel_keys, false});
    }
}

void draw_recent(const State& state, Commands& commands) {
    const bool any = !state.interface.recent.empty();
    if (ImGui::BeginMenu("Open recent", any)) {
        for (const std::string& pack : state.interface.recent) {
            ui::need_glyphs(pack);
            if (ImGui::MenuItem(pack.c_str())) commands.push(OpenFile{pack});
        }
        ImGui::EndMenu();
    }
    ui::mark("menu", "recent");
}

void draw_file(const State& state, Commands& commands) {
    item("open", "Open...", "Ctrl+O", true, commands, ShowDialog{Dialog::open_file});
    draw_recent(state, commands);
    item("sample", "Open the sample", "", true, commands, OpenSample{});
    item("bake", "Bake heights...", "", true, commands, ShowDialog{Dialog::bake});
    ImGui::Separator();
    if (ImGui::MenuItem("Save profile", "Ctrl+S")) save(state, commands);
    ui::mark("menu", "save");
    item("save-as", "Save profile as...", "Ctrl+Shift+S", true, commands, ShowDialog{Dialog::save_profile});
    item("compare", "Compare profiles...", "", true, commands, ShowDialog{Dialog::compare});
    item("save-path", "Save camera path as...", "", !state.route.empty(), commands, ShowDialog{Dialog::save_path});
    ImGui::Separator();
    item("export", "Export glTF...", "", state.scene.open(), commands, ShowDialog{Dialog::snapshot});
    item("screenshot", "Screenshot...", "", true, commands, ShowDialog{Dialog::screenshot});
    ImGui::Separator();
    item("quit", "Quit", "Ctrl+Q", true, commands, Quit{});
}

void draw_edit(const State& state, Commands& commands) {
    const Document& document = state.document;
    char label[96]; // what follows ### tells it from others, whatever it is called
    (void)std::snprintf(label, sizeof label, "Undo %s###undo", undo_label(state));
    item("undo", label, "Ctrl+Z", document.undo_steps() + state.route.undo_steps() + state.ground.undo_steps > 0,
         commands, Undo{});
    (void)std::snprintf(label, sizeof label, "Redo %s###redo", redo_label(state));
    item("redo", label, "Ctrl+Shift+Z", document.redo_steps() + state.route.redo_steps() + state.ground.redo_steps > 0,
         commands, Redo{});
    ImGui::Separator();
    if (ImGui::MenuItem("Copy profile as C++")) ImGui::SetClipboardText(profile_as_cpp(document.profile()).c_str());
    ui::mark("menu", "copy-cpp");
    item("defaults", "Reset all values", "", true, commands, ResetProfile{});
    if (ImGui::MenuItem("Lower threshold", "[")) change_threshold(state, 1 / threshold_step, commands);
    ui::mark("menu", "lower");
    if (ImGui::MenuItem("Raise threshold", "]")) change_threshold(state, threshold_step, commands);
    ui::mark("menu", "raise");
}

void draw_camera_menu(const State& state, Commands& commands) {
    const bool open = state.scene.open();
    constexpr const char* names[] = {"Fly", "Orbit", "Follow the path"};
    constexpr const char* keys[] = {"1", "2", "3"};
    for (int i = 0; i < 3; ++i) {
        const auto navigation = static_cast<Navigation>(i);
        if (ImGui::MenuItem(names[i], keys[i], state.eye.navigation == navigation, open))
            commands.push(SetNavigation{navigation});
    }
    item("home", "Look at the whole terrain", "Home", open, commands, ViewAll{});
    if (ImGui::MenuItem("Freeze refinement", "F", state.eye.frozen, open))
        commands.push(FreezeRefinement{!state.eye.frozen});
    ImGui::Separator();
    const Route& route = state.route;
    item("record", route.recording() ? "Stop recording" : "Record a path", "R", open, commands,
         RecordPath{!route.recording()});
    item("add-point", "Add a point", "N", open, commands, AddPoint{});
    item("play", route.playing() ? "Pause" : "Play the path", "P", open && !route.empty(), commands,
         PlayPath{!route.playing()});
}

// What the strips beside the picture do by hand. The menu stays, so that a width is found step by step.
void draw_column_items(const State& state, Commands& commands) {
    if (ImGui::BeginMenu("Columns")) {
        ImGui::PushItemFlag(ImGuiItemFlags_SelectableDontClosePopup, true);
        const Arrangement& a = state.interface.arrangement;
        constexpr const char* names[] = {"Left column", "Right column, in wide windows"};
        for (std::size_t c = 0; c < columns; ++c) {
            const auto column = static_cast<Column>(c);
            const auto width = static_cast<double>(a.width_px[c]), split = static_cast<double>(a.split[c]);
            if (c > 0) ImGui::Separator();
            ImGui::PushID(names[c]);
            const auto entry = [&](const char* name, const char* label, ColumnPart part, double value) {
                item(name, label, "", true, commands, ArrangeColumn{column, part, value});
            };
            ImGui::TextDisabled("%s", names[c]);
            entry("wider", "Wider", ColumnPart::width, width + column_step_px);
            entry("narrower", "Narrower", ColumnPart::width, width - column_step_px);
            entry("upper-taller", "Upper panel taller", ColumnPart::split, split + split_step);
            entry("upper-shorter", "Upper panel shorter", ColumnPart::split, split - split_step);
            if (ImGui::MenuItem("Folded", "", a.folded[c]))
                commands.push(ArrangeColumn{column, ColumnPart::folded, a.folded[c] ? 0.0 : 1.0});
            ImGui::PopID();
        }
        ImGui::PopItemFlag();
        ImGui::EndMenu();
    }
    ui::mark("menu", "columns");
}

void draw_window_items(const State& state, Commands& commands) {
    const Interface& i = state.interface;
    const auto entry = [&](const char* label, const char* keys, Switch which, bool on) {
        if (ImGui::MenuItem(label, keys, on)) commands.push(SetSwitch{which, !on});
        ui::mark("menu", switch_names[static_cast<int>(which)]);
    };
    entry("Panels", "Tab", Switch::show_panels, i.arrangement.panels);
    if (ImGui::BeginMenu("Floating panels")) {
        for (int p = 0; p < panels; ++p) {
            const auto panel = static_cast<Panel>(p);
            const bool floats = i.arrangement.floats(panel);
            if (ImGui::MenuItem(title_of(panel), "", floats)) commands.push(FloatPanel{panel, !floats, {}});
            ui::mark("float", panel_names[p]);
        }
        ImGui::EndMenu();
    }
    ui::mark("menu", "floating");
    draw_column_items(state, commands);
    entry("Picture only", "F11", Switch::picture_only, i.picture_only);
    entry("Keyboard in the panels", "F6", Switch::panel_keys, i.panel_keys);
    entry("Half resolution while moving", "", Switch::half_resolution, i.half_resolution);
    entry("Probe the ground", "I", Switch::probe, state.probe.on);
}

void draw_view_menu(const State& state, Commands& commands) {
    const int next = (static_cast<int>(state.interface.mode) + 1) % session::picture_modes;
    for (int i = 0; i < session::picture_modes; ++i) {
        const auto mode = static_cast<session::PictureMode>(i);
        if (ImGui::MenuItem(label_of(mode), i == next ? "M" : "", state.interface.mode == mode))
            commands.push(SetPictureMode{mode});
    }
    ImGui::Separator();
    for (int i = 0; i < overlays; ++i) {
        const auto overlay = static_cast<Overlay>(i);
        const bool on = state.shows(overlay);
        if (ImGui::MenuItem(label_of(overlay), overlay == Overlay::wireframe ? "G" : "", on))
            commands.push(SetOverlay{overlay, !on});
    }
    ImGui::Separator();
    if (ImGui::MenuItem("Pause graphs and times", "T", state.measures.held(), state.scene.open()))
        commands.push(HoldMeasures{!state.measures.held()});
    ui::mark("menu", "hold-graphs");
    draw_window_items(state, commands);
    ImGui::Separator();
    constexpr struct {
        const char* label;
        double scale;
    } scales[] = {{"100%", 1}, {"125%", 1.25}, {"150%", 1.5}, {"200%", 2}};
    for (const auto& s : scales)
        if (ImGui::MenuItem(s.label, "", state.interface.scale == s.scale)) commands.push(SetScale{s.scale});
}

// What is edited, and whether it is saved, on the bar's right.
void draw_profile_name(const State& state, Commands& commands) {
    ui::need_glyphs(state.files.profile_name);
    const char* const name = state.files.profile_name.c_str();
    const float width = ImGui::CalcTextSize(name).x + ImGui::GetStyle().WindowPadding.x;
    const float at = ImGui::GetWindowWidth() - width;
    if (at > ImGui::GetCursorPosX()) ImGui::SetCursorPosX(at);
    const bool unsaved = state.document.unsaved();
    if (unsaved) ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
    ImGui::TextUnformatted(name);
    if (unsaved) ImGui::PopStyleColor();
    ui::mark("menu", "profile");
    if (ImGui::IsItemClicked()) save(state, commands);
    if (ui::begin_tip()) {
        char text[700];
        const std::string& path = state.document.path();
        (void)std::snprintf(text, sizeof text, "The profile: %.500s%s",
                            path.empty() ? "the defaults, not saved to a file yet" : path.c_str(),
                            unsaved ? "\nIt has unsaved changes; click to save them." : "");
        ImGui::TextUnformatted(text);
        ui::end_tip();
    }
}

// A control that went away while it was held, with its panel, has been let go. The sun is held in the picture, where no
// control is active: until the button is up that drag goes on, and ends itself.
void release_held(const State& state, Commands& commands) {
    const ProfileKey* const held = state.document.held();
    const bool by_mouse = ImGui::IsMouseDown(ImGuiMouseButton_Left) || ImGui::IsMouseReleased(ImGuiMouseButton_Left);
    if (held != nullptr && !by_mouse && !ImGui::IsAnyItemActive())
        commands.push(SetKey{held, held->get(state.document.profile()), false});
}

} // namespace

void draw_shortcuts(const State& state, PanelState& own, Commands& commands) {
    release_held(state, commands);
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantTextInput || io.KeyAlt || io.KeySuper || is_modal(state.interface.dialog)) return;
    if (ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) return; // a menu, or a list that is dropped down
    if (!io.KeyCtrl) {
        window_keys(state, commands);
        if (pressed('[', true)) change_threshold(state, 1 / threshold_step, commands);
        if (pressed(']', true)) change_threshold(state, threshold_step, commands);
        return;
    }
    if (pressed('Z', true)) io.KeyShift ? commands.push(Redo{}) : commands.push(Undo{});
    if (pressed('Y', true)) commands.push(Redo{});
    if (pressed('O', false)) commands.push(ShowDialog{Dialog::open_file});
    if (pressed('S', false)) io.KeyShift ? commands.push(ShowDialog{Dialog::save_profile}) : save(state, commands);
    if (pressed('F', false)) {
        commands.push(ShowPanel{Panel::tune});
        own.search_begins = true;
    }
    if (pressed('Q', false)) commands.push(Quit{});
}

void draw_menu(const State& state, PanelState& own, Commands& commands) {
    if (!ImGui::BeginMainMenuBar()) return;
    const bool open = state.scene.open();
    // F10 opens the first menu, and again the one after that which is open; Alt with its first letter opens any.
    int& shown = own.menu_shown;
    constexpr const char* labels[] = {"File", "Edit", "Camera", "View", "Tools", "Help"};
    constexpr int menus = static_cast<int>(std::size(labels));
    int opens = pressed(key::f10, false) ? (shown + 1) % menus : -1;
    for (int m = 0; ImGui::GetIO().KeyAlt && m < menus; ++m)
        if (pressed(labels[m][0], false)) opens = m;
    if (opens >= 0 && !is_modal(state.interface.dialog)) {
        ImGui::OpenPopup(labels[opens]);
        keyboard::show_focus();
    }
    int i = 0;
    shown = -1;
    const auto menu = [&](const char* name, auto draw) {
        if (ImGui::BeginMenu(labels[i])) {
            shown = i;
            draw(state, commands);
            ImGui::EndMenu();
        }
        ++i;
        ui::mark("menu", name);
    };
    menu("file", draw_file);
    menu("edit", draw_edit);
    menu("camera", draw_camera_menu);
    menu("view", draw_view_menu);
    menu("tools", [open](const State& s, Commands& c) {
        item("tune", "Auto-tune", "", open, c, ShowGroup{Group::auto_tune_threshold, true});
        item("benchmark", "Benchmark", "", open, c, ShowGroup{Group::auto_tune_benchmark, true});
        ImGui::Separator();
        item("cancel-job", "Cancel the job", "", s.job.running, c, CancelJob{});
    });
    menu("help", [](const State&, Commands& c) {
        item("keys", "Keys", "F1", true, c, ShowDialog{Dialog::keys});
        item("messages", "Messages", "", true, c, ShowDialog{Dialog::messages});
    });
    draw_profile_name(state, commands);
    ImGui::EndMainMenuBar();
}

} // namespace fjell::editor
