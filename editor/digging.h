// Moving ground in the editor: what brushes do to it, kept in the pack's journal as it happens, and undone.
//
// A stroke's dabs are stamps on the chosen edit layer. They are pushed to the session's edits, and written to the
// journal (fjell/io/journal.h) when the stroke ends: one record and one step of undo. What takes something back, or
// switches a layer, makes the ground of its area anew: the pack's heights with all that is left, as a bake of the
// journal has them, pushed as heights. So the ground that is shown is always what the journal says.
//
// Thread: the frame's. Memory: the journal's stamps, and those of the steps. Failure: io::Failure, in one line, as the
// journal has it; what could not be written is not shown either.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fjell/edit.h"
#include "fjell/io/journal.h"
#include "fjell/pack.h"
#include "session/flight_edits.h"
#include "session/options.h"

namespace fjell::editor {

enum class BrushTool : std::uint8_t {
    off,
    raise,
    lower,
    level,
    smooth,
    noise,
    crater,
    restore,
    hole,
    fill,
    road,
    paint,
    unpaint,
    lock,
    unlock
};
inline constexpr const char* brush_tool_names[] = {"off",   "raise",  "lower",   "level", "smooth",
                                                   "noise", "crater", "restore", "hole",  "fill",
                                                   "road",  "paint",  "unpaint", "lock",  "unlock"};

struct Brush {
    BrushTool tool = BrushTool::off;
    double radius_m = 20;  // within which it applies wholly
    double falloff_m = 20; // beyond, where it fades out
    double amount_m = 2;   // of a dab: metres up, down or deep; of noise: as high as its hills
    double strength = 1;   // 0 to 1
    double error_m = 0.05; // of a lock: how far off the drawn ground may be
    // Of paint: a colour, sRGB, and a material of the pack's splat map by number; no_material: the colour alone.
    std::uint8_t rgb[3] = {92, 78, 60};
    std::uint8_t material = no_material;
};
inline constexpr double least_brush_m = 0.01, most_brush_m = 100'000, most_amount_m = 10'000, most_lock_m = 1000;

// Beyond its radius; locks do not fade out.
[[nodiscard]] constexpr double falloff_of(const Brush& brush) {
    return brush.tool == BrushTool::lock || brush.tool == BrushTool::unlock ? 0 : brush.falloff_m;
}

// For sessions of the editor: the ground may change, and is the journal's from the beginning. A journal that cannot be
// read is left out; Digging says why.
void open_with_journal(session::FlightOptions& options);

// A dab there. level_m: the height that BrushTool::level makes.
[[nodiscard]] Stamp dab_of(const Brush& brush, double x_m, double z_m, double level_m, std::uint32_t seed);

// A road along places of the scene, 2 at least, each with its ground's height: a stamp of at most max_path_points. Its
// heights are the ground's without what is short beside the brush's width; it begins and ends on the ground.
[[nodiscard]] io::KeptStamp road_of(const Brush& brush, std::span<const StampPoint> places);

class Digging {
public:
    // Opens the pack's journal if there is one. What keeps it from being used is problem(), not a Failure.
    Digging(std::string pack, const PackHeader& header);

    [[nodiscard]] const std::string& problem() const { return problem_; } // empty: it can be dug
    [[nodiscard]] std::span<const io::JournalLayer> layers() const;       // from the bottom up
    [[nodiscard]] const std::string& path() const { return path_; }       // the journal's, there or not
    [[nodiscard]] std::uint64_t file_bytes() const { return journal_ ? journal_->file_bytes() : 0; }
    // The layer that strokes go to: its place; none: a new one is made for the next stroke.
    [[nodiscard]] std::optional<std::size_t> chosen() const;
    void choose(std::size_t place);

    [[nodiscard]] const std::string& notice() const { return notice_; } // of opening the journal; empty: none
    // Another one whenever what the accessors give has changed.
    [[nodiscard]] std::uint64_t version() const { return version_; }

    // The edits of the session that is shown; null: there are none. Those of a new session have the journal's stamps.
    void use(session::FlightEdits* edits) { edits_ = edits; }

    void dab(const Stamp& stamp); // begins a stroke if none is under way
    void end_stroke();
    [[nodiscard]] bool in_stroke() const { return !stroke_.empty(); }

    void add_layer(const std::string& name);
    // What is not given stays as it is. to: its new place.
    void set_layer(std::size_t place, std::optional<bool> on, std::optional<double> strength,
                   std::optional<std::size_t> to);
    void remove_layer(std::size_t place);

    void undo();
    void redo();
    // The edits have refused what the last step, or an undo or a redo, has asked of the ground: it is as it was before.
    void take_back_refused();
    [[nodiscard]] std::size_t undo_steps() const { return undo_.size(); }
    [[nodiscard]] std::size_t redo_steps() const { return redo_.size(); }
    // next_edit_stamp() (editor/document.h) of the next step back, or forward; 0: there is none.
    [[nodiscard]] std::uint64_t undo_stamp() const { return undo_.empty() ? 0 : undo_.back().stamp; }
    [[nodiscard]] std::uint64_t redo_stamp() const { return redo_.empty() ? 0 : redo_.back().stamp; }

private:
    // What a step did: a layer's content and place before and after; none where it was not there.
    struct LayerState {
        io::JournalLayer layer; // with its stamps only where the layer comes or goes
        std::size_t place = 0;
    };
    struct Step {
        std::uint64_t stamp = 0;
        std::optional<LayerState> before, after; // of a layer
        std::uint32_t layer = 0;                 // of a stroke
        std::vector<std::uint64_t> ids;          // the stroke's stamps, as long as they are there
        std::vector<io::KeptStamp> stamps;
        bool with_before = false; // is undone with the step before it, and done again with it
    };
    io::Journal& journal();
    [[nodiscard]] std::size_t place_of(std::uint32_t layer) const;
    void did(Step step);
    enum class Last : std::uint8_t { nothing, step, undo, redo }; // done, and may be refused
    void pass(std::vector<Step>& from, std::vector<Step>& to, void (Digging::*how)(Step&), Last last);
    void take_back(Step& step);
    void repeat(Step& step);
    void put_layer(std::optional<LayerState>& from, std::optional<LayerState>& to);
    void renew(std::span<const io::KeptStamp> changed);
    // What lies over the ground: paint, or locks.
    void renew_over(std::span<const io::KeptStamp> changed, bool (&is)(StampShape), StampShape bare);
    void renew_layer(const io::JournalLayer& layer);

    std::string pack_, path_, problem_, notice_;
    PackHeader header_;
    std::unique_ptr<io::Journal> journal_;
    session::FlightEdits* edits_ = nullptr;
    std::uint32_t chosen_ = 0; // 0: the top one
    std::uint64_t version_ = 1;
    std::vector<io::KeptStamp> stroke_;
    bool made_layer_ = false; // for the stroke that is under way
    std::vector<Step> undo_, redo_;
    Last last_ = Last::nothing;
};

} // namespace fjell::editor
