// The vertices around one: its children and its parents, found once for each change.
#pragma once

#include <cstdint>

#include "cut/pages.h"

namespace fjell {

struct Around {
    Site site;
    std::uint32_t child[4];  // vertices; no_index: there is none, or its page has no state
    std::uint32_t parent[2]; // the same; a tile's root has none
    bool lacks_child;        // a child's page has no state
};

// In a full page most of them are a constant number of places away, or in a page whose number follows from shifts.
// Those of vertices on a page's border, and of page 0, are looked for by their places in the tree: find_around() calls
// find_around_anywhere() for them, which finds the same wherever a vertex lies and takes some ten times as long.
[[nodiscard]] Around find_around(const Pages& pages, std::uint32_t vertex);
[[nodiscard]] Around find_around_anywhere(const Pages& pages, std::uint32_t vertex);

} // namespace fjell
