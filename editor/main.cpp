// fjell-editor: tunes thresholds and budgets over a terrain, by eye and by number. Exit codes: 0 done, 1 the input is
// at fault, 2 usage, 3 the machine (disk, memory, GPU) is.
#include "editor/app.h"
#include "editor/options.h"
#include "fjell/io/failure.h"

int main(int argc, char** argv) {
    return fjell::io::run_tool("fjell-editor", [&] {
        fjell::editor::Options options;
        if (!fjell::editor::parse_options(argc, argv, options)) return 0;
        fjell::io::catch_interrupts();
        return fjell::editor::App(std::move(options)).run();
    });
}
