// Applies commands: the one place, beside the frame itself, that changes the state.
//
// Failure: none gets out. What a command cannot do becomes a message and the state stays as it was.
#pragma once

#include "editor/command.h"
#include "editor/engine.h"
#include "editor/jobs/jobs.h"
#include "editor/state.h"

namespace fjell::editor {

// What commands act on.
struct HandlerContext {
    State& state;
    Engine& engine;
    Jobs& jobs;
};

void apply(const Command& command, HandlerContext context);

// Brings the engine in line with the document, unless a control is still held; what cannot be had is reverted.
void follow_document(HandlerContext context);
// After a pack was opened: scene, camera, measures.
void start_at_scene(HandlerContext context);
// What a frame does to the camera of itself: the path that is played or recorded goes on, and Eye::view and ground_m
// follow. A pack must be open, and Interface know the picture's size.
void move_camera(HandlerContext context, double seconds);

} // namespace fjell::editor
