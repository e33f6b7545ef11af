// What the live cut keeps in the host's memory, between frames.
#pragma once

#include "cut/bulk.h"
#include "cut/frame.h"
#include "cut/mesh.h"
#include "cut/morph.h"
#include "cut/pages.h"
#include "cut/schedule.h"
#include "cut/views.h"
#include "cut/visibility.h"

namespace fjell {

struct CutState {
    BlockHead head;
    CutBudget budget;
    Pages pages;
    Work work;
    BulkPass bulk;
    Mesh mesh;
    Views views;
    Visibility visibility;
    Governor governor;
    Morphing morphing;
    Frame frame;
};

// The cut behind a handle, or nullptr: also when its terrain is gone.
[[nodiscard]] inline CutState* find_cut(const LiveCut& cut) {
    CutState* const s = find(cut);
    return s != nullptr && find(s->pages.grid.handle) != nullptr ? s : nullptr;
}
inline constexpr Status no_cut{StatusCode::invalid_handle, "cut, or its terrain"};

// No vertex active, every page that is loaded entered, all slots free; and no triangle yet.
void reset(CutState& s);
// After reset(): two triangles a tile, and every tile's root due.
void begin_at_roots(const Pages& pages, Work& work, Mesh& mesh);

} // namespace fjell
