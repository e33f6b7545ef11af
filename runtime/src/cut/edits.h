// What the cut does when the ground has been edited (fjell/edit.h).
#pragma once

namespace fjell {

struct CutState;

// Heights of pages may count from other bases now. Before anything of this frame is evaluated, by the bulk pass too.
// O(states of pages) if the ground has changed.
void follow_bases(CutState& s);

// Takes what was edited since the last call: vertices that are drawn move to their new heights, pages are bounded anew,
// and all groups around what has changed are due. Not while the bulk pass is under way. O(vertices around the changes);
// of everything, when more has changed than the terrain remembers.
void follow_ground(CutState& s);

} // namespace fjell
