#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void item(const char* name, const char* label, const char* keys, bool enabled, Commands& commands, Command command) {
    if (ImGui::MenuItem(label, keys, false, enabled)) commands.push(std::move(command));
    ui::mark("menu", name);
}

} // namespace

void draw_menu(const State& state, Commands& commands) {
    if (!ImGui::BeginMainMenuBar()) return;
    const bool open = state.scene.open();
    if (ImGui::BeginMenu("File")) {
        item("open", "Open...", "Ctrl+O", true, commands, ShowDialog{Dialog::open_file});
        item("quit", "Quit", "Ctrl+Q", true, commands, Quit{});
        ImGui::EndMenu();
    }
    ui::mark("menu", "file");
    if (ImGui::BeginMenu("Edit")) {
        item("undo", "Undo", "Ctrl+Z", state.document.undo_steps() > 0, commands, Undo{});
        item("redo", "Redo", "Ctrl+Shift+Z", state.document.redo_steps() > 0, commands, Redo{});
        ImGui::EndMenu();
    }
    ui::mark("menu", "edit");
    if (ImGui::BeginMenu("Tools")) {
        item("tune", "Auto-tune...", "", open, commands, ShowDialog{Dialog::tune});
        item("benchmark", "Benchmark...", "", open, commands, ShowDialog{Dialog::benchmark});
        ImGui::EndMenu();
    }
    ui::mark("menu", "tools");
    if (ImGui::BeginMenu("Help")) {
        item("keys", "Keys", "F1", true, commands, ShowDialog{Dialog::keys});
        item("messages", "Messages", "", true, commands, ShowDialog{Dialog::messages});
        ImGui::EndMenu();
    }
    ui::mark("menu", "help");
    ImGui::EndMainMenuBar();
}

} // namespace fjell::editor
