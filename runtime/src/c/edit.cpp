// fjell/fjell_c.h: moving ground, and its maps.
#include "shared/c_convert.h"

using namespace fjell;
using namespace fjell::c_api;

void fjell_set_default_edit_budget(FjellEditBudget* budget) {
    write(EditBudget{}, budget);
}
void fjell_set_default_stamp(FjellStamp* stamp) {
    write(Stamp{}, stamp);
}
void fjell_set_default_edit_settings(FjellEditSettings* settings) {
    write(EditSettings{}, settings);
}
bool fjell_has_room_for_holes(const FjellPackHeader* header) {
    return has_room_for_holes(at(header));
}
bool fjell_has_room_for_locks(const FjellPackHeader* header) {
    return has_room_for_locks(at(header));
}
size_t fjell_edits_bytes(const FjellPackHeader* header, const FjellEditBudget* budget) {
    const In in(budget);
    return in.ok ? edits_bytes(at(header), in.value) : 0;
}
FjellStatus fjell_create_edits(FjellTerrain terrain, const FjellEditBudget* budget, void* memory, size_t memory_bytes,
                               FjellEdits* edits) {
    const In in(budget);
    if (!in.ok) return refused(struct_size);
    if (edits == nullptr) return refused("edits");
    Edits made;
    return give(create_edits(to_cpp(terrain), in.value, span_of(memory, memory_bytes), made), made, edits);
}
FjellStatus fjell_destroy_edits(FjellEdits edits) {
    return to_c(destroy_edits(to_cpp(edits)));
}
FjellStatus fjell_check_stamp(const FjellStamp* stamp) {
    const In in(stamp);
    return in.ok ? to_c(check_stamp(in.value)) : refused(struct_size);
}
FjellStatus fjell_push_stamp(FjellEdits edits, const FjellStamp* stamp, uint64_t* id) {
    const In in(stamp);
    if (!in.ok) return refused(struct_size);
    if (id == nullptr) return refused("id");
    StampId pushed = 0;
    const Status status = push_stamp(to_cpp(edits), in.value, pushed);
    if (status.ok()) *id = pushed;
    return to_c(status);
}
FjellStampResult fjell_stamp_state(FjellEdits edits, uint64_t id) {
    return to_c(stamp_state(to_cpp(edits), id));
}
FjellStatus fjell_update_edits(FjellEdits edits, const FjellView* views, size_t view_count,
                               const FjellEditSettings* settings, FjellEditReport* report) {
    const Views seen(views, view_count);
    const In in(settings);
    if (!seen.ok || !in.ok || !fits(report)) return refused(struct_size);
    EditReport done;
    const Status status = update_edits(to_cpp(edits), seen.all(), in.value, done);
    if (status.ok()) write(done, report);
    return to_c(status);
}
uint32_t fjell_count_always_drawn(FjellEdits edits) {
    return count_always_drawn(to_cpp(edits));
}
uint32_t fjell_take_ground_changes(FjellEdits edits, uint64_t* cursor, FjellGroundRect* rects, size_t rect_count,
                                   bool* lost) {
    std::uint64_t from = cursor == nullptr ? 0 : *cursor;
    bool missed = false;
    const std::uint32_t taken =
        take_ground_changes(to_cpp(edits), from, span_of(reinterpret_cast<GroundRect*>(rects), rect_count), missed);
    if (cursor != nullptr) *cursor = from;
    if (lost != nullptr) *lost = missed;
    return taken;
}

void fjell_set_default_ground_maps_budget(FjellGroundMapsBudget* budget) {
    write(GroundMapsBudget{}, budget);
}
size_t fjell_ground_maps_bytes(const FjellPackHeader* header, const FjellGroundMapsBudget* budget) {
    const In in(budget);
    return in.ok ? ground_maps_bytes(at(header), in.value) : 0;
}
FjellStatus fjell_create_ground_maps(FjellTerrain terrain, const FjellGroundMapsBudget* budget, void* memory,
                                     size_t memory_bytes, FjellGroundMaps* maps) {
    const In in(budget);
    if (!in.ok) return refused(struct_size);
    if (maps == nullptr) return refused("maps");
    GroundMaps made;
    return give(create_ground_maps(to_cpp(terrain), in.value, span_of(memory, memory_bytes), made), made, maps);
}
FjellStatus fjell_destroy_ground_maps(FjellGroundMaps maps) {
    return to_c(destroy_ground_maps(to_cpp(maps)));
}
FjellStatus fjell_note_map_commands(FjellGroundMaps maps, const FjellMapCommand* commands, size_t command_count) {
    return to_c(note_map_commands(to_cpp(maps), span_of(reinterpret_cast<const MapCommand*>(commands), command_count)));
}
FjellStatus fjell_update_ground_maps(FjellGroundMaps maps, const FjellTileMap* normals, size_t normal_count,
                                     FjellGroundMapsReport* report) {
    if (!fits(report)) return refused(struct_size);
    GroundMapsReport made;
    const Status status =
        update_ground_maps(to_cpp(maps), span_of(reinterpret_cast<const TileMap*>(normals), normal_count), made);
    if (status.ok()) write(made, report);
    return to_c(status);
}
FjellStatus fjell_paint_map(FjellTerrain terrain, FjellMapKind map, uint32_t tile, uint32_t side_log2, void* blocks,
                            size_t block_bytes, bool* changed) {
    bool painted = false;
    const Status status =
        paint_map(to_cpp(terrain), static_cast<MapKind>(map), tile, side_log2, span_of(blocks, block_bytes), painted);
    if (changed != nullptr) *changed = painted;
    return to_c(status);
}
uint32_t fjell_take_paint_changes(FjellTerrain terrain, uint64_t* cursor, FjellGroundRect* rects, size_t rect_count,
                                  bool* lost) {
    std::uint64_t from = cursor == nullptr ? 0 : *cursor;
    bool missed = false;
    const std::uint32_t taken =
        take_paint_changes(to_cpp(terrain), from, span_of(reinterpret_cast<GroundRect*>(rects), rect_count), missed);
    if (cursor != nullptr) *cursor = from;
    if (lost != nullptr) *lost = missed;
    return taken;
}
size_t fjell_paint_bytes(FjellTerrain terrain) {
    return paint_bytes(to_cpp(terrain));
}
FjellStatus fjell_copy_paint(FjellTerrain terrain, void* memory, size_t memory_bytes, FjellPaint* paint) {
    if (paint == nullptr) return refused("paint");
    Paint made;
    return give(copy_paint(to_cpp(terrain), span_of(memory, memory_bytes), made), made, paint);
}
FjellStatus fjell_paint_map_of(FjellPaint paint, FjellMapKind map, uint32_t tile, uint32_t side_log2, void* blocks,
                               size_t block_bytes, bool* changed) {
    bool painted = false;
    const Status status =
        paint_map(to_cpp(paint), static_cast<MapKind>(map), tile, side_log2, span_of(blocks, block_bytes), painted);
    if (changed != nullptr) *changed = painted;
    return to_c(status);
}
const FjellMapPatch* fjell_ground_map_patches(FjellGroundMaps maps, size_t* count) {
    return elements(ground_map_patches(to_cpp(maps)), count);
}
