// The game's engine, a library of its own: nothing of Fjell shows here.
#pragma once

// Loads the pack whole, then streams it from its file; draws into nothing and asks for heights. Prints what it saw, on
// lines that are the same wherever it runs. Returns main()'s exit code.
__attribute__((visibility("default"))) int play(const char* pack);
