#include "editor/panels/fonts.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <fontconfig/fontconfig.h>

#include "editor/panels/ui.h"

namespace fjell::editor::ui {

namespace {

constexpr ImWchar latin[] = {0x20, 0xFF, 0x2010, 0x2026, 0};
constexpr std::size_t most_asked = 4096; // of the atlas, whatever is in a folder

struct Free {
    void operator()(FcPattern* p) const { FcPatternDestroy(p); }
    void operator()(FcFontSet* s) const { FcFontSetDestroy(s); }
};

// The system's fonts that stb_truetype reads, the nearest to the one that all texts are in first.
class SystemFonts {
public:
    SystemFonts() {
        const std::unique_ptr<FcPattern, Free> wanted(
            FcNameParse(reinterpret_cast<const FcChar8*>("DejaVu Sans,sans-serif:style=Book:scalable=true")));
        if (!wanted) return;
        FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
        FcDefaultSubstitute(wanted.get());
        FcResult result = FcResultMatch;
        sorted_.reset(FcFontSort(nullptr, wanted.get(), FcFalse, nullptr, &result));
    }
    struct Face {
        std::string file;
        int index = 0;
        friend auto operator<=>(const Face&, const Face&) = default;
    };
    // For texts in general (character 0), or that has the character; no file: there is none.
    [[nodiscard]] Face face_for(unsigned character) const {
        for (int i = 0; sorted_ && i < sorted_->nfont; ++i) {
            FcPattern* const font = sorted_->fonts[i];
            FcChar8 *file = nullptr, *format = nullptr;
            FcCharSet* characters = nullptr;
            Face face;
            if (FcPatternGetString(font, FC_FILE, 0, &file) != FcResultMatch ||
                FcPatternGetString(font, FC_FONTFORMAT, 0, &format) != FcResultMatch ||
                FcPatternGetCharSet(font, FC_CHARSET, 0, &characters) != FcResultMatch ||
                !FcCharSetHasChar(characters, character != 0 ? character : 'a'))
                continue;
            const char* const kind = reinterpret_cast<const char*>(format);
            if (std::strcmp(kind, "TrueType") != 0 && std::strcmp(kind, "CFF") != 0) continue;
            (void)FcPatternGetInteger(font, FC_INDEX, 0, &face.index);
            if (face.index > 0xFFFF) continue; // a named instance of a variable font
            face.file = reinterpret_cast<const char*>(file);
            return face;
        }
        return {};
    }

private:
    std::unique_ptr<FcFontSet, Free> sorted_;
};

} // namespace

void need_glyph(unsigned character) {
    if (character <= latin[1] || (character >= latin[2] && character <= latin[3]) ||
        character > IM_UNICODE_CODEPOINT_MAX)
        return;
    Glyphs& glyphs = context().glyphs;
    const auto c = static_cast<ImWchar>(character);
    const auto at = std::ranges::lower_bound(glyphs.asked, c);
    if ((at != glyphs.asked.end() && *at == c) || glyphs.asked.size() >= most_asked) return;
    glyphs.asked.insert(at, c);
    glyphs.more = true;
}

void need_glyphs(std::string_view utf8) {
    for (std::size_t i = 0; i < utf8.size();) {
        const auto first = static_cast<unsigned char>(utf8[i]);
        const std::size_t bytes = first < 0x80 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
        if (bytes > 1 && i + bytes <= utf8.size()) {
            unsigned c = first & (0x7Fu >> bytes);
            for (std::size_t k = 1; k < bytes; ++k) c = c << 6 | (static_cast<unsigned char>(utf8[i + k]) & 0x3Fu);
            need_glyph(c);
        }
        i += bytes;
    }
}

bool glyphs_are_missing() {
    return context().glyphs.more;
}

void add_fonts(ImFontAtlas& atlas, float pixels) {
    static const SystemFonts fonts;
    Glyphs& glyphs = context().glyphs;
    glyphs.more = false;
    glyphs.ranges.clear();
    const SystemFonts::Face text = fonts.face_for(0);
    ImFontConfig config;
    config.FontNo = text.index;
    if (text.file.empty() || atlas.AddFontFromFileTTF(text.file.c_str(), pixels, &config, latin) == nullptr) {
        config.SizePixels = pixels * 13 / 14; // ImGui's own, which is legible at any scale too
        atlas.AddFontDefault(&config);
        return;
    }
    std::map<SystemFonts::Face, std::vector<ImWchar>> by_face;
    for (const ImWchar c : glyphs.asked)
        if (SystemFonts::Face face = fonts.face_for(c); !face.file.empty()) {
            std::vector<ImWchar>& ranges = by_face[std::move(face)];
            ranges.insert(ranges.end(), {c, c});
        }
    for (auto& [face, ranges] : by_face) {
        ranges.push_back(0);
        glyphs.ranges.push_back(std::move(ranges));
        config.FontNo = face.index;
        config.MergeMode = true;
        atlas.AddFontFromFileTTF(face.file.c_str(), pixels, &config, glyphs.ranges.back().data());
    }
}

} // namespace fjell::editor::ui
