// fjell/fjell_c.h: views, both methods, and what their meshes keep to.
#include "shared/c_convert.h"

using namespace fjell;
using namespace fjell::c_api;

namespace {

FjellMeshView mesh_of(const MeshView& m) {
    return {elements(m.vertices), m.vertices.size(), m.indices.data(),
            m.indices.size(),     elements(m.tiles), m.tiles.size(),
            m.dirty_begin,        m.dirty_end,       static_cast<uint8_t>(m.topology)};
}
MeshView mesh_of(const FjellMeshView& m) {
    return {static_cast<Topology>(m.topology),
            span_of(reinterpret_cast<const MeshVertex*>(m.vertices), m.vertex_count),
            span_of(m.indices, m.index_count),
            span_of(reinterpret_cast<const TileRange*>(m.tiles), m.tile_count),
            m.dirty_begin,
            m.dirty_end};
}

} // namespace

// --- fjell/view.h ---

void fjell_set_default_view(FjellView* view) {
    write(View{}, view);
}
FjellStatus fjell_make_view(FjellVec3 eye_m, FjellVec3 forward, FjellVec3 up, double fov_y_rad, uint32_t width_px,
                            uint32_t height_px, double near_m, double far_m, FjellView* view) {
    if (view == nullptr) return refused("view");
    if (!fits(view)) return refused(struct_size);
    write(make_view(to_cpp(eye_m), to_cpp(forward), to_cpp(up), fov_y_rad, width_px, height_px, near_m, far_m), view);
    return {FJELL_OK, ""};
}
FjellStatus fjell_validate_view(const FjellView* view) {
    const In in(view);
    return in.ok ? to_c(validate(in.value)) : refused(struct_size);
}
FjellFrustum fjell_make_frustum(const FjellView* view) {
    const In in(view);
    return to_c(in.ok ? make_frustum(in.value) : Frustum{});
}
double fjell_focal_length_px(const FjellView* view) {
    const In in(view);
    return in.ok ? focal_length_px(in.value) : 0;
}
double fjell_corner_factor(const FjellView* view) {
    const In in(view);
    return in.ok ? corner_factor(in.value) : 1;
}

// --- fjell/cut.h ---

void fjell_set_default_cut_budget(FjellCutBudget* budget) {
    write(CutBudget{}, budget);
}
void fjell_set_default_cut_settings(FjellCutSettings* settings) {
    write(CutSettings{}, settings);
}
const char* fjell_cut_budget_field(uint32_t bit) {
    return budget_field(static_cast<CutBudgetBit>(bit));
}
FjellStatus fjell_validate_cut_settings(const FjellCutSettings* settings) {
    const In in(settings);
    return in.ok ? to_c(validate(in.value)) : refused(struct_size);
}
size_t fjell_cut_bytes(FjellTerrain terrain, const FjellCutBudget* budget) {
    const In in(budget);
    return in.ok ? cut_bytes(to_cpp(terrain), in.value) : 0;
}
FjellStatus fjell_create_cut(FjellTerrain terrain, const FjellCutBudget* budget, void* memory, size_t memory_bytes,
                             FjellLiveCut* cut) {
    const In in(budget);
    if (!in.ok) return refused(struct_size);
    if (cut == nullptr) return refused("cut");
    LiveCut made;
    return give(create_cut(to_cpp(terrain), in.value, span_of(memory, memory_bytes), made), made, cut);
}
FjellStatus fjell_destroy_cut(FjellLiveCut cut) {
    return to_c(destroy_cut(to_cpp(cut)));
}
FjellStatus fjell_update_cut(FjellLiveCut cut, const FjellView* views, size_t view_count,
                             const FjellCutSettings* settings, FjellCutReport* report) {
    const Views seen(views, view_count);
    const In in(settings);
    if (!seen.ok || !in.ok || !fits(report)) return refused(struct_size);
    CutReport done;
    const Status status = update_cut(to_cpp(cut), seen.all(), in.value, done);
    if (status.ok()) write(done, report);
    return to_c(status);
}
FjellStatus fjell_rebuild_cut(FjellLiveCut cut, const FjellView* views, size_t view_count,
                              const FjellCutSettings* settings, FjellCutReport* report) {
    const Views seen(views, view_count);
    const In in(settings);
    if (!seen.ok || !in.ok || !fits(report)) return refused(struct_size);
    CutReport done;
    const Status status = rebuild_cut(to_cpp(cut), seen.all(), in.value, done);
    if (status.ok()) write(done, report);
    return to_c(status);
}
FjellStatus fjell_cut_release_page(FjellLiveCut cut, uint32_t tile, uint32_t page, bool* released) {
    if (released == nullptr) return refused("released");
    return to_c(cut_release_page(to_cpp(cut), tile, page, *released));
}
FjellStatus fjell_cut_cancel_release(FjellLiveCut cut, uint32_t tile, uint32_t page) {
    return to_c(cut_cancel_release(to_cpp(cut), tile, page));
}
float fjell_morph_age_s(float now_s, float then_s) {
    return morph_age_s(now_s, then_s);
}
float fjell_morphed_height_m(FjellTerrain terrain, const FjellMeshVertex* vertex, const FjellMorphVertex* morph,
                             const FjellMorphFrame* frame) {
    return morphed_height_m(to_cpp(terrain), at(vertex), at(morph), at(frame));
}
FjellCutMesh fjell_cut_mesh(FjellLiveCut cut) {
    const CutMesh live = cut_mesh(to_cpp(cut));
    return {mesh_of(live.mesh), elements(live.morph), live.morph.size(), to_c(live.frame)};
}
FjellCutChanges fjell_cut_take_changes(FjellLiveCut cut) {
    return to_c(cut_take_changes(to_cpp(cut)));
}
// The loops of for_each_run(), which a callback of C would have to leave for every run.
bool fjell_next_run(const uint64_t* bits, const uint32_t* words, size_t word_count, FjellRun* run) {
    while (run->bits_left == 0) {
        if (run->words_begun >= word_count) return false;
        run->bits_left = bits[words[run->words_begun++]];
    }
    const auto first = static_cast<uint32_t>(std::countr_zero(run->bits_left));
    const auto count = static_cast<uint32_t>(std::countr_one(run->bits_left >> first));
    run->first = words[run->words_begun - 1] * 64 + first;
    run->count = count;
    run->bits_left &= first + count == 64 ? 0 : ~uint64_t{0} << (first + count);
    return true;
}

// --- fjell/compact.h ---

void fjell_compact_vertices(const FjellMeshVertex* vertices, const FjellMorphVertex* morphs, size_t count,
                            FjellCompactVertex* to) {
    compact_vertices(span_of(reinterpret_cast<const MeshVertex*>(vertices), count),
                     span_of(reinterpret_cast<const MorphVertex*>(morphs), count),
                     span_of(reinterpret_cast<CompactVertex*>(to), count));
}
void fjell_compact_indices(const uint32_t* indices, size_t count, uint16_t* to) {
    compact_indices(span_of(indices, count), span_of(to, count));
}
uint32_t fjell_index_bytes(const FjellCutBudget* budget) {
    const In in(budget);
    return in.ok ? index_bytes(in.value) : 0;
}
double fjell_compact_share(const FjellMorphView* view) {
    return compact_share(at(view));
}
float fjell_compact_rise_m(uint16_t rise) {
    return compact_rise_m(rise);
}
float fjell_compact_length_m(uint16_t error_or_radius) {
    return compact_length_m(error_or_radius);
}

// --- fjell/recursive.h ---

void fjell_set_default_recursive_budget(FjellRecursiveBudget* budget) {
    write(RecursiveBudget{}, budget);
}
void fjell_set_default_refine_settings(FjellRefineSettings* settings) {
    write(RefineSettings{}, settings);
}
size_t fjell_recursive_bytes(FjellTerrain terrain, const FjellRecursiveBudget* budget) {
    const In in(budget);
    return in.ok ? recursive_bytes(to_cpp(terrain), in.value) : 0;
}
FjellStatus fjell_create_recursive(FjellTerrain terrain, const FjellRecursiveBudget* budget, void* memory,
                                   size_t memory_bytes, FjellRecursiveMethod* method) {
    const In in(budget);
    if (!in.ok) return refused(struct_size);
    if (method == nullptr) return refused("method");
    RecursiveMethod made;
    return give(create_recursive(to_cpp(terrain), in.value, span_of(memory, memory_bytes), made), made, method);
}
FjellStatus fjell_destroy_recursive(FjellRecursiveMethod method) {
    return to_c(destroy_recursive(to_cpp(method)));
}
FjellStatus fjell_update_recursive(FjellRecursiveMethod method, const FjellView* view,
                                   const FjellRefineSettings* settings, FjellFrameReport* report) {
    const In seen(view);
    const In in(settings);
    if (!seen.ok || !in.ok || !fits(report)) return refused(struct_size);
    FrameReport done;
    const Status status = update_recursive(to_cpp(method), seen.value, in.value, done);
    if (status.ok()) write(done, report);
    return to_c(status);
}
FjellMeshView fjell_recursive_mesh(FjellRecursiveMethod method) {
    return mesh_of(recursive_mesh(to_cpp(method)));
}

// --- fjell/measure.h ---

FjellMeasuredError fjell_measure_error(FjellTerrain terrain, const FjellMeshView* mesh, const FjellView* view,
                                       const FjellFrustum* frustum) {
    const In seen(view);
    if (!seen.ok || mesh == nullptr) return {};
    return to_c(
        measure_error(to_cpp(terrain), mesh_of(*mesh), seen.value, frustum == nullptr ? nullptr : &at(frustum)));
}
double fjell_bound_cut_error_px(FjellLiveCut cut, const FjellView* view, bool corner_safe, double at_least_px) {
    const In seen(view);
    return seen.ok ? bound_error_px(to_cpp(cut), seen.value, corner_safe, at_least_px) : unbounded_px;
}
double fjell_bound_recursive_error_px(FjellRecursiveMethod method, const FjellView* view, bool corner_safe,
                                      double at_least_px) {
    const In seen(view);
    return seen.ok ? bound_error_px(to_cpp(method), seen.value, corner_safe, at_least_px) : unbounded_px;
}
