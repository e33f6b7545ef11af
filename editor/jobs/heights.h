// What a bake would read, looked at before it begins: extents, heights, coordinates, a picture, and what is missing.
//
// A thread of its own opens the files as the bake would, reads all rows of a small field and some of a large one, and
// paints them small. Ownership: HeightLook owns the thread. Thread: its functions on the frame's. Failure: none; what
// cannot be read is HeightFacts::problem, in the dialog's words.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "editor/command.h"
#include "fjell/gl/palette.h"

namespace fjell::baker {
class HeightSource;
} // namespace fjell::baker

namespace fjell::editor {

// A material of the rules; its colour is that of the preview and of the legend, no texture's.
struct RuleLayer {
    std::string name;
    double share = 0; // of the ground, about
    gl::Rgb8 rgb{};
};
struct RulesLook {
    std::size_t rules = 0;
    std::vector<RuleLayer> layers;     // as the pack numbers them
    double bare_share = 0;             // of the ground that no rule covers
    std::vector<float> covered;        // of each cell, 0..1
    std::vector<std::uint32_t> colour; // of each cell, RGB, 0 in the highest byte
};
// heights_m: of cells_x x cells_y cells that cover the source, NaN where there is none.
[[nodiscard]] RulesLook look_at_rules(const std::string& path, const baker::HeightSource& source, std::uint32_t cells_x,
                                      std::uint32_t cells_y, const std::vector<float>& heights_m);

inline constexpr std::size_t ramp_strip = 48; // colours of the ramp, from the lowest height to the highest

struct HeightFacts {
    bool known = false; // what follows, down to the problem
    std::uint32_t columns = 0, rows = 0;
    std::uint64_t file_bytes = 0;
    double spacing_m[2] = {0, 0};
    bool has_spacing = false;          // of its own, or given; otherwise the one above is not known
    std::string crs, reprojected_from; // empty: none
    bool unit_named = false;           // of the heights, by the file
    bool all_read = false;             // otherwise some rows, and what follows is about
    double least_m = 0, most_m = 0, void_share = 0;
    std::string image;             // what the texture is, for people; empty: there is none
    std::size_t rules = 0;         // in the file of rules; 0: there is none
    std::vector<RuleLayer> layers; // of those, by share
    double bare_share = 0;         // of the ground that no rule covers

    std::string problem;            // why this cannot be baked; empty: it can
    BakeField at = BakeField::none; // that would mend it
    std::string proposed, because;  // a value of that field, and why that one; empty: none is known

    // RGBA bytes, sRGB: the heights, and to their right the texture.
    std::uint32_t width_px = 0, height_px = 0, image_px = 0;
    std::vector<std::uint32_t> texels;
    std::array<gl::Rgb8, ramp_strip> strip{};
};

// What the dialog that bakes is about to ask for.
struct BakeDraft {
    BakePack pack;
    std::uint64_t version = 0;     // counts its changes
    std::uint64_t given = 0;       // counts what came from elsewhere than the dialog: opened, dropped, browsed files
    bool output_is_chosen = false; // by the user; otherwise it follows the heights
    bool output_exists = false;
    std::string output_problem; // why the pack cannot be written there
    bool looking = false;       // the facts are those of an earlier draft
    double look_share = 0;      // of the heights that are looked at, read
    HeightFacts facts;
    std::uint64_t looks = 0; // that ended
    unsigned texture = 0;    // GL name of the picture; 0: there is none
    bool asks = false;       // BakePack::asks of the bake that runs
    std::string ready;       // a pack that was baked while another terrain was flown: the user decides
};

// The facts of one draft; stop is looked at between rows. share: of the rows that have been read; null: not told.
[[nodiscard]] HeightFacts look_at_heights(const BakePack& pack, const std::atomic<bool>& stop,
                                          std::atomic<double>* share = nullptr);

class HeightLook {
public:
    HeightLook() = default;
    ~HeightLook();
    HeightLook(const HeightLook&) = delete;
    HeightLook& operator=(const HeightLook&) = delete;

    // Looks anew where the draft has changed, and brings what has been found. True: there is something new.
    bool follow(BakeDraft& draft);
    [[nodiscard]] bool news() const { return look_ && look_->done.load(std::memory_order_acquire); }

private:
    struct Look {
        BakePack of;
        HeightFacts facts;
        std::atomic<bool> stop{false}, done{false};
        std::atomic<double> share{0};
    };
    void begin(const BakePack& pack);

    BakePack looked_at_;
    std::uint64_t version_ = 0; // of the draft
    std::shared_ptr<Look> look_;
    std::jthread thread_;
};

} // namespace fjell::editor
