// What the directory says of a page (PageBound) against the page itself.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/terrain.h"

namespace fjell::baker {

// Empty: the bound holds for every vertex of the page, and no narrower one would. Otherwise what is wrong, in words.
// The page must be loaded. O(vertices of a page).
[[nodiscard]] std::string wrong_bound(const Pack& pack, const Terrain& terrain, std::uint32_t tile, std::uint32_t page);

} // namespace fjell::baker
