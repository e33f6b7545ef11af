// Frames that are slow: all that is done with keys and mouse between two of them arrives at once, and nothing is lost.
#include <catch2/catch.hpp>

#include <functional>
#include <string>

#include "editor/input.h"

using namespace fjell::editor;
using Kind = InputEvent::Kind;

namespace {

constexpr int control = 341, backspace = 259, enter = 257;
constexpr int with_control = 2;

// An interface without a picture. Whatever is pushed lies between two of its frames.
struct SlowWindow {
    SlowWindow() {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {200, 100};
        io.DeltaTime = 0.5F; // 2 frames a second
        io.IniFilename = nullptr;
        io.KeyMap[ImGuiKey_Backspace] = backspace;
        io.KeyMap[ImGuiKey_Enter] = enter;
        unsigned char* pixels = nullptr;
        int width = 0, height = 0;
        io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
        frames([] {}, 2); // the window is there before anything is done in it
    }
    ~SlowWindow() { ImGui::DestroyContext(); }

    void key(int code, bool down, int mods = 0) { queue.push({Kind::key, code, down, false, mods, 0, pointer}); }
    void strike(int code, int mods = 0) { key(code, true, mods), key(code, false, mods); }
    void type(const std::string& letters) {
        for (const char c : letters) {
            key(c - 'a' + 'A', true);
            queue.push({Kind::character, c, false, false, 0, 0, pointer});
            key(c - 'a' + 'A', false);
        }
    }
    void click(ImVec2 at, double time_s) {
        for (const bool down : {true, false}) queue.push({Kind::button, 0, down, false, 0, 0, at}, time_s);
    }
    // Frames until nothing waits, and some more; the pointer is where it is now in all of them.
    void run(const std::function<void()>& draw) {
        frames(draw, 8);
        CHECK_FALSE(queue.waits());
    }
    void frames(const std::function<void()>& draw, int least) {
        for (int left = least; left > 0 || (least > 2 && queue.waits()); --left) {
            REQUIRE(left > -200);
            ImGuiIO& io = ImGui::GetIO();
            io.MousePos = pointer; // as the back end has it
            if (least > 2) queue.deliver(io, counts, {});
            ImGui::NewFrame();
            ImGui::SetNextWindowPos({0, 0});
            ImGui::SetNextWindowSize({200, 100});
            ImGui::Begin("window", nullptr, ImGuiWindowFlags_NoDecoration);
            draw();
            ImGui::End();
            ImGui::EndFrame();
        }
    }

    InputQueue queue;
    InputCounts counts;
    ImVec2 pointer{190, 90};
};

} // namespace

TEST_CASE("two quick redos are two, and so are two strokes of a letter") {
    SlowWindow w;
    w.key(control, true, with_control);
    w.strike('Y', with_control);
    w.strike('Y', with_control);
    w.key(control, false);
    w.strike('M');
    w.strike('M');
    int redos = 0, modes = 0;
    w.run([&] {
        if (ImGui::IsKeyPressed('Y', false)) {
            CHECK(ImGui::GetIO().KeyCtrl);
            ++redos;
        }
        if (ImGui::IsKeyPressed('M', false)) {
            CHECK_FALSE(ImGui::GetIO().KeyCtrl);
            ++modes;
        }
    });
    CHECK(redos == 2);
    CHECK(modes == 2);
    CHECK(w.counts.keys == 10);
    CHECK_FALSE(ImGui::GetIO().KeysDown['Y']);
    CHECK_FALSE(ImGui::GetIO().KeyCtrl);
}

TEST_CASE("a click keeps the place where it was made, however far the pointer has gone since") {
    SlowWindow w;
    w.click({20, 20}, 1);
    w.click({120, 20}, 2);
    int left = 0, right = 0;
    w.run([&] {
        ImGui::SetCursorPos({10, 10});
        left += ImGui::Button("left", {60, 30});
        ImGui::SetCursorPos({100, 10});
        right += ImGui::Button("right", {60, 30});
    });
    CHECK(left == 1);
    CHECK(right == 1);
    CHECK(w.counts.buttons == 4);
    CHECK_FALSE(ImGui::GetIO().MouseDown[0]);
}

TEST_CASE("a double click is one between slow frames, and two clicks far apart are none") {
    for (const double apart_s : {0.1, 0.6}) {
        SlowWindow w;
        w.click({20, 20}, 1);
        w.click({20, 20}, 1 + apart_s);
        int clicks = 0, doubles = 0;
        w.run([&] {
            clicks += ImGui::IsMouseClicked(0);
            doubles += ImGui::IsMouseDoubleClicked(0);
        });
        CHECK(clicks == 2);
        CHECK(doubles == (apart_s < 0.3 ? 1 : 0));
    }
}

TEST_CASE("letters that follow a click into a field are the field's, in their order, and no shortcut hears them") {
    SlowWindow w;
    w.click({50, 20}, 1);
    w.type("frap");
    w.strike(backspace);
    w.type("me");
    char text[16] = "";
    int shortcuts = 0;
    w.run([&] {
        ImGui::SetCursorPos({10, 10});
        ImGui::InputText("##field", text, sizeof text);
        if (ImGui::GetIO().WantTextInput) return;
        for (const char key : {'F', 'R', 'A', 'P', 'M', 'E'}) shortcuts += ImGui::IsKeyPressed(key, false);
    });
    CHECK(std::string(text) == "frame");
    CHECK(shortcuts == 0);
    CHECK(w.counts.characters == 6);
}

TEST_CASE("what is typed is entered before the click that follows it") {
    SlowWindow w;
    w.click({50, 20}, 1);
    w.type("ab");
    w.strike(enter);
    w.click({50, 60}, 2);
    char text[16] = "";
    std::string order;
    w.run([&] {
        ImGui::SetCursorPos({10, 10});
        if (ImGui::InputText("##field", text, sizeof text, ImGuiInputTextFlags_EnterReturnsTrue))
            order += std::string("entered ") + text + ", ";
        ImGui::SetCursorPos({10, 50});
        if (ImGui::Button("button", {100, 30})) order += "pressed";
    });
    CHECK(order == "entered ab, pressed");
}
