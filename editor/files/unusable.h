// What ends the reading of a value in a file of the editor's own, where whoever reads names the file, or the key, and
// says what becomes of it. Nobody is shown it.
#pragma once

#include <exception>

namespace fjell::editor {

struct Unusable : std::exception {};

} // namespace fjell::editor
