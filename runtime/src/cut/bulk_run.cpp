// When the bulk pass runs: for a rebuild at once, after a jump of the camera in as many frames as it takes.
#include "cut/bulk.h"
#include "cut/pages.h"
#include "cut/refine.h"
#include "cut/sight.h"

namespace fjell {

void finish_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    while (b.phase == BulkPhase::triangles) (void)step_bulk(s);
    if (b.phase == BulkPhase::built) install_mesh(s);
    while (b.phase >= BulkPhase::releasing && step_install(s)) {
    }
    drop_bulk(s.pages, s.bulk, s.mesh);
}

BulkStatus build_bulk(CutState& s) {
    begin_bulk(s.pages, s.bulk, s.mesh, false);
    BulkStatus status = BulkStatus::unfinished;
    while (status == BulkStatus::unfinished) status = step_bulk(s);
    if (status != BulkStatus::built) return status;
    install_mesh(s);
    finish_bulk(s);
    return status;
}

namespace {

// Is it worth while to build anew what is seen, beside what there is? Not where work is counted one by one, or where
// there is hardly any room.
bool may_build_beside(const Mesh& mesh, const Frame& frame) {
    const std::uint32_t free = free_vertices(mesh);
    return frame.settings.items == unlimited_items && free >= (mesh.capacity - free) / 4;
}

// It takes states of pages that it finds, while those of what is drawn stay.
bool needs_pages(const Pages& pages) {
    return may_lack_pages(pages) && free_pages(pages) < pages.count / 2;
}

} // namespace

bool run_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    // A page that the host has unloaded without waiting takes its vertices along, at once; and who has begun to count
    // items has this frame's.
    if (b.phase != BulkPhase::idle && (s.frame.settings.items != unlimited_items || has_lost_pages(s.pages)))
        finish_bulk(s);
    b.again = b.again || s.views.leapt;
    CutReport& r = s.frame.report;
    do {
        if (b.again && b.phase < BulkPhase::triangles) {
            drop_bulk(s.pages, s.bulk, s.mesh);
            if (needs_pages(s.pages) && reclaim_page(s.pages, s.work, s.mesh, s.morphing)) {
                ++r.visits;
                continue;
            }
            b.again = false;
            sync_pages(s); // a slot may hold another page by now
            if (may_build_beside(s.mesh, s.frame)) {
                watch_visited_pages(s);
                begin_bulk(s.pages, s.bulk, s.mesh, true);
            } else if (r.visits != 0) {
                ++r.visits; // or a replay that ends after the one before would still mean to begin
            }
        }
        if (b.phase == BulkPhase::idle) return false;
        if (b.phase >= BulkPhase::releasing) {
            s.views.jumped = step_install(s) && s.views.jumped;
            r.visits += b.units;
            continue;
        }
        const BulkStatus status = step_bulk(s);
        r.visits += b.units;
        switch (status) {
        case BulkStatus::unfinished: break;
        case BulkStatus::built:
            r.deactivations += s.mesh.capacity - free_vertices(s.mesh) - s.mesh.corner_count;
            r.activations += b.taken;
            install_mesh(s);
            break;
        case BulkStatus::no_vertices:
        case BulkStatus::no_triangles:
        case BulkStatus::no_pages: return false; // one by one, then
        }
    } while (!out_of_time(s.frame, true));
    return b.phase != BulkPhase::idle;
}

} // namespace fjell
