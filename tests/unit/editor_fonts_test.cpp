// What the window's letters are: those of a text font, and of the system's fonts whatever a name asks for.
#include <catch2/catch.hpp>

#include <string>

#include <fontconfig/fontconfig.h>
#include <imgui_internal.h> // CalcWordWrapPositionA goes by spaces and commas; ours by spaces alone

#include "editor/panels/ui.h"

using namespace fjell::editor;

namespace {

struct Lettered {
    Lettered() {
        ImGui::CreateContext();
        ImGui::GetIO().UserData = &context;
        ImGui::GetIO().IniFilename = nullptr;
        ImGui::GetIO().DisplaySize = {400, 400};
        style();
    }
    ~Lettered() { ImGui::DestroyContext(); }
    static void style() {
        ui::apply_style(1);
        unsigned char* pixels = nullptr;
        int width = 0, height = 0;
        ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    }
    [[nodiscard]] static bool has(unsigned c) {
        return ImGui::GetIO().Fonts->Fonts[0]->FindGlyphNoFallback(static_cast<ImWchar>(c)) != nullptr;
    }
    ui::Context context;
};

bool some_font_has(unsigned c) {
    FcCharSet* const set = FcCharSetCreate();
    FcCharSetAddChar(set, c);
    FcPattern* const pattern = FcPatternCreate();
    FcPatternAddCharSet(pattern, FC_CHARSET, set);
    FcPatternAddBool(pattern, FC_SCALABLE, FcTrue);
    FcObjectSet* const objects = FcObjectSetBuild(FC_FILE, nullptr);
    FcFontSet* const found = FcFontList(nullptr, pattern, objects);
    const bool any = found != nullptr && found->nfont > 0;
    if (found != nullptr) FcFontSetDestroy(found);
    FcObjectSetDestroy(objects);
    FcPatternDestroy(pattern);
    FcCharSetDestroy(set);
    return any;
}

} // namespace

TEST_CASE("a name's letters are there once it is shown, of whatever script a font of the system has") {
    Lettered ui;
    CHECK(Lettered::has('a'));
    CHECK(Lettered::has(0xE5)); // of Latin
    CHECK_FALSE(ui::glyphs_are_missing());
    ui::need_glyphs("plain.fjell");
    CHECK_FALSE(ui::glyphs_are_missing());
    const std::string names = "Łódź Ψηλορείτης Эльбрус Հայաստան საქართველო 富士山 한라산";
    ui::need_glyphs(names);
    CHECK(ui::glyphs_are_missing());
    Lettered::style();
    CHECK_FALSE(ui::glyphs_are_missing());
    for (const unsigned c : {0x141u, 0x3A8u, 0x42Du, 0x540u, 0x10E1u, 0x5BCCu, 0xD55Cu}) {
        INFO(c);
        CHECK(Lettered::has(c) == some_font_has(c));
    }
    CHECK(Lettered::has(0x42D)); // DejaVu has it at least
    ui::need_glyphs(names);      // what no font has is not looked for again
    CHECK_FALSE(ui::glyphs_are_missing());
}

TEST_CASE("text that ends in the middle of a letter asks for nothing and is no harm") {
    Lettered ui;
    for (const char* cut : {"\xE5", "a\xE5\xAF", "\xF0\x9F", "\xFF\xFF", "\x80"}) ui::need_glyphs(cut);
    Lettered::style();
    CHECK(Lettered::has('a'));
}

TEST_CASE("lines end at spaces alone: a number is never broken at its comma") {
    Lettered ui;
    // So narrow that ImGui's own would break "peak 1,234,567" behind a comma.
    const char* const text = "used 1,234,567, peak 7,654,321";
    const float width = ImGui::GetIO().Fonts->Fonts[0]->CalcTextSizeA(14, 1e9F, 0, "used 1,234,").x + 1;
    ImFont& font = *ImGui::GetIO().Fonts->Fonts[0];
    const char* const theirs = font.CalcWordWrapPositionA(1, text, text + std::string(text).size(), width);
    CHECK(theirs[-1] == ','); // or the case would prove nothing
    ImGui::NewFrame();
    ImGui::SetNextWindowSize({width + 2 * ImGui::GetStyle().WindowPadding.x, 200});
    ImGui::Begin("w", nullptr, ImGuiWindowFlags_NoDecoration);
    const float before = ImGui::GetCursorPosY();
    ui::wrapped(text);
    const float lines = (ImGui::GetItemRectSize().y) / ImGui::GetTextLineHeight();
    CHECK(ImGui::GetCursorPosY() > before);
    ImGui::End();
    ImGui::EndFrame();
    CHECK(lines == Approx(4)); // used | 1,234,567, | peak | 7,654,321
}
