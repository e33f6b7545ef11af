// The commands that lay a map's shapes on a pack's ground: roads, rivers, locks. Each returns the program's exit code.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "baker/vectors/roads.h"

namespace fjell::baker {

struct VectorArguments {
    std::string pack, file, from; // from: a layer of the file
    std::string journal;          // empty: the pack's own
    std::string layer;            // of the journal
    bool replace = false;
    LineOptions roads, rivers;
    std::string paint, material;
    std::optional<double> lock_error_m;
    std::string json_path;
    bool quiet = false;
};

struct VectorCommands {
    CLI::App* roads;
    CLI::App* rivers;
    CLI::App* locks;
};

[[nodiscard]] VectorCommands declare_vectors(CLI::App& app, VectorArguments& arguments);

int run_vectors(const VectorArguments& arguments, LineKind kind);
int run_locks(const VectorArguments& arguments);

} // namespace fjell::baker
