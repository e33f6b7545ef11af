// fjell/fjell_c.h: streaming.
#include "shared/c_convert.h"

using namespace fjell;
using namespace fjell::c_api;

void fjell_set_default_stream_budget(FjellStreamBudget* budget) {
    write(StreamBudget{}, budget);
}
void fjell_set_default_stream_settings(FjellStreamSettings* settings) {
    write(StreamSettings{}, settings);
}
FjellMapLayers fjell_map_layers(const FjellPackHeader* header, const FjellStreamBudget* budget, uint8_t kind) {
    const In in(budget);
    return to_c(in.ok ? map_layers(at(header), in.value, static_cast<MapKind>(kind)) : MapLayers{});
}
uint64_t fjell_map_layer_bytes(const FjellMapLayers* sizes, uint8_t kind) {
    return map_layer_bytes(at(sizes), static_cast<MapKind>(kind));
}
const char* fjell_stream_budget_field(uint32_t bit) {
    return budget_field(static_cast<StreamBudgetBit>(bit));
}
size_t fjell_stream_bytes(const FjellPack* pack, FjellTerrain terrain, const FjellStreamBudget* budget) {
    const In in(budget);
    return in.ok ? stream_bytes(at(pack), to_cpp(terrain), in.value) : 0;
}
FjellStatus fjell_create_stream(const FjellPack* pack, FjellTerrain terrain, FjellLiveCut cut,
                                const FjellStreamBudget* budget, void* memory, size_t memory_bytes,
                                FjellStream* stream) {
    const In in(budget);
    if (!in.ok) return refused(struct_size);
    if (stream == nullptr) return refused("stream");
    Stream made;
    return give(create_stream(at(pack), to_cpp(terrain), to_cpp(cut), in.value, span_of(memory, memory_bytes), made),
                made, stream);
}
FjellStatus fjell_destroy_stream(FjellStream stream) {
    return to_c(destroy_stream(to_cpp(stream)));
}
FjellStatus fjell_update_stream(FjellStream stream, const FjellView* views, size_t view_count,
                                const FjellCutSettings* cut, const FjellStreamSettings* settings,
                                FjellStreamReport* report) {
    const Views seen(views, view_count);
    const In of_cut(cut);
    const In in(settings);
    if (!seen.ok || !of_cut.ok || !in.ok || !fits(report)) return refused(struct_size);
    StreamReport done;
    const Status status = update_stream(to_cpp(stream), seen.all(), of_cut.value, in.value, done);
    if (status.ok()) write(done, report);
    return to_c(status);
}
FjellStatus fjell_stream_retry_failed(FjellStream stream) {
    return to_c(stream_retry_failed(to_cpp(stream)));
}

const FjellStreamFailure* fjell_stream_failures(FjellStream stream, size_t* count) {
    return elements(stream_failures(to_cpp(stream)), count);
}
const FjellPageArrival* fjell_stream_page_arrivals(FjellStream stream, size_t* count) {
    return elements(stream_page_arrivals(to_cpp(stream)), count);
}
const FjellMapCommand* fjell_stream_map_commands(FjellStream stream, size_t* count) {
    return elements(stream_map_commands(to_cpp(stream)), count);
}
const FjellTileMap* fjell_stream_tile_maps(FjellStream stream, uint8_t kind, size_t* count) {
    return elements(stream_tile_maps(to_cpp(stream), static_cast<MapKind>(kind)), count);
}
FjellMapLayers fjell_stream_map_layers(FjellStream stream, uint8_t kind) {
    return to_c(stream_map_layers(to_cpp(stream), static_cast<MapKind>(kind)));
}
FjellStatus fjell_min_lod_grid(const FjellTileMap* maps, size_t map_count, uint32_t tiles_x, uint32_t tile,
                               float out[9]) {
    if (out == nullptr) return refused("out");
    return to_c(min_lod_grid(span_of(reinterpret_cast<const TileMap*>(maps), map_count), tiles_x, tile,
                             *reinterpret_cast<float(*)[9]>(out)));
}
FjellStatus fjell_min_lod_grid_of(const FjellTileMap* maps, size_t map_count, FjellTerrain terrain, uint32_t tile,
                                  float out[9]) {
    if (out == nullptr) return refused("out");
    return to_c(min_lod_grid(span_of(reinterpret_cast<const TileMap*>(maps), map_count), to_cpp(terrain), tile,
                             *reinterpret_cast<float(*)[9]>(out)));
}

bool fjell_stream_next_request(FjellStream stream, FjellStreamRequest* request) {
    StreamRequest next;
    if (request == nullptr || !stream_next_request(to_cpp(stream), next)) return false;
    *request = to_c(next);
    return true;
}
bool fjell_stream_still_wanted(FjellStream stream, uint32_t ticket) {
    return stream_still_wanted(to_cpp(stream), ticket);
}
FjellStatus fjell_stream_provide(FjellStream stream, uint32_t ticket, const void* stored, size_t stored_bytes) {
    return to_c(stream_provide(to_cpp(stream), ticket, span_of(stored, stored_bytes)));
}
FjellStatus fjell_stream_provide_decoded(FjellStream stream, uint32_t ticket, const void* decoded,
                                         size_t decoded_bytes) {
    return to_c(stream_provide_decoded(to_cpp(stream), ticket, span_of(decoded, decoded_bytes)));
}
FjellStatus fjell_stream_fail(FjellStream stream, uint32_t ticket, bool unwanted) {
    return to_c(stream_fail(to_cpp(stream), ticket, unwanted));
}
