// The commands around journals (fjell/io/journal.h): journal, rebase. Each returns the program's exit code.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace fjell::baker {

struct JournalArguments {
    std::string pack, journal; // empty: the pack's own
    std::string stamps, layer; // --add
    std::vector<std::string> on, off, remove;
    std::vector<std::string> strength, move; // NAME=VALUE
    bool compact = false;
    std::string stamps_out, json_path;
    std::string from, rebased; // rebase
    bool quiet = false;
};

struct JournalCommands {
    CLI::App* journal;
    CLI::App* rebase;
};

[[nodiscard]] JournalCommands declare_journals(CLI::App& app, JournalArguments& arguments);

int run_journal(const JournalArguments& arguments);
int run_rebase(const JournalArguments& arguments);

} // namespace fjell::baker
