// A crater under a body: it falls, and rests on the floor.
#pragma once

#include <string>

#include "../ground/streamed_ground.h"

namespace physics {

struct Dug {
    std::string broken;           // the promise that was; empty: none
    double fell_m = 0, share = 0; // share: how far contacts were off at most, of what is allowed
    int patches = 0, still_steps = 0,
        changed_steps = 0; // read again; until it rested, and until the ground had changed
};

// whole: the same ground in memory, which gets the same crater. good_m: ground that is no further off carries bodies.
[[nodiscard]] Dug dig(ground::StreamedGround& ground, ground::Yardstick& whole, double accuracy_m, float good_m);

} // namespace physics
