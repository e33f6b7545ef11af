#include "baker/cli/journals.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/cli/reports.h"
#include "baker/cli/summary.h"
#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "fjell/io/pack_file.h"
#include "io/command_line.h"
#include "io/file.h"
#include "io/stamps.h"

namespace fjell::baker {

using io::Failure;
using io::Journal;
using io::JournalLayer;
using nlohmann::json;

namespace {

std::string journal_of(const JournalArguments& a) {
    return a.journal.empty() ? io::journal_path(a.pack) : a.journal;
}

bool changes(const JournalArguments& a) {
    return !a.stamps.empty() || !a.on.empty() || !a.off.empty() || !a.remove.empty() || !a.strength.empty() ||
           !a.move.empty() || a.compact;
}

const JournalLayer* find(const Journal& journal, const std::string& name) {
    const auto found = std::ranges::find(journal.layers(), name, &JournalLayer::name);
    return found != journal.layers().end() ? &*found : nullptr;
}
const JournalLayer& layer_named(const Journal& journal, const std::string& name) {
    if (const JournalLayer* const layer = find(journal, name)) return *layer;
    std::string names;
    for (const JournalLayer& layer : journal.layers()) names += (names.empty() ? "" : ", ") + layer.name;
    throw Failure(1, fmt::format("{}: has no layer \"{}\"{}{}", journal.path(), name,
                                 names.empty() ? "; it has none at all" : "; its layers are ", names));
}
std::size_t place_of(const Journal& journal, const JournalLayer& layer) {
    return static_cast<std::size_t>(&layer - journal.layers().data());
}

// NAME=VALUE, at the last =.
std::pair<std::string, double> named_number(const std::string& text, const char* option) {
    const std::size_t at = text.rfind('=');
    double value = 0;
    if (at != std::string::npos && at != 0) {
        const auto [end, error] = std::from_chars(text.data() + at + 1, text.data() + text.size(), value);
        if (error == std::errc{} && end == text.data() + text.size()) return {text.substr(0, at), value};
    }
    throw Failure(2, fmt::format("{}: needs NAME=NUMBER, and has {}", option, text));
}

void add_stamps(Journal& journal, const JournalArguments& a) {
    const std::vector<io::TimedStamp> stamps = io::read_stamps(a.stamps); // all of it is right, or nothing is added
    const JournalLayer* const there = find(journal, a.layer);
    const std::uint32_t layer = there != nullptr ? there->id : journal.add_layer(a.layer);
    std::vector<io::KeptStamp> all;
    for (const io::TimedStamp& stamp : stamps) all.push_back(stamp.what);
    (void)journal.add_stamps(layer, all);
}

void switch_layer(Journal& journal, const std::string& name, bool on) {
    JournalLayer layer = layer_named(journal, name);
    layer.on = on;
    journal.set_layer(layer, place_of(journal, layer_named(journal, name)));
}

void change(Journal& journal, const JournalArguments& a) {
    if (!a.stamps.empty()) add_stamps(journal, a);
    for (const std::string& name : a.on) switch_layer(journal, name, true);
    for (const std::string& name : a.off) switch_layer(journal, name, false);
    for (const std::string& text : a.strength) {
        const auto [name, strength] = named_number(text, "--strength");
        JournalLayer layer = layer_named(journal, name);
        layer.strength = static_cast<float>(strength);
        journal.set_layer(layer, place_of(journal, layer_named(journal, name)));
    }
    for (const std::string& text : a.move) {
        const auto [name, place] = named_number(text, "--move");
        const JournalLayer layer = layer_named(journal, name);
        const auto last = static_cast<double>(journal.layers().size() - 1);
        if (!(place >= 0 && place <= last))
            throw Failure(2, fmt::format("--move: a place is 0 (the bottom) to {} (the top), and not {}", last, place));
        journal.set_layer(layer, static_cast<std::size_t>(place));
    }
    for (const std::string& name : a.remove) journal.remove_layer(layer_named(journal, name).id);
    if (a.compact)
        journal.compact();
    else
        journal.commit();
}

void print(const Journal& journal) {
    fmt::print("{}: {} layers, {} bytes, of which --compact saves {}\n", journal.path(), journal.layers().size(),
               journal.file_bytes(), journal.dead_bytes());
    for (std::size_t place = journal.layers().size(); place-- != 0;) { // the top first, as people stack things
        const JournalLayer& layer = journal.layers()[place];
        fmt::print("{:4} {:3} {:4} {:8} stamps  {}\n", place, layer.on ? "on" : "off", layer.strength,
                   layer.stamps.size(), layer.name);
    }
}

} // namespace

JournalCommands declare_journals(CLI::App& app, JournalArguments& a) {
    JournalCommands c{};
    c.journal = app.add_subcommand("journal", "show or change a pack's journal: layers of stamps beside the pack");
    c.journal->add_option("PACK", a.pack, "a pack, or the folder of a pack set")->required();
    c.journal->add_option("--journal", a.journal, "another file than PACK.journal");
    auto* const add = c.journal->add_option("--add", a.stamps, "add the stamps of a file (content/edits) to --layer");
    auto* const layer = c.journal->add_option("--layer", a.layer, "the layer of --add; a new one comes on top");
    add->needs(layer), layer->needs(add);
    const auto several = [](CLI::Option* option, const char* type) {
        option->type_name(type)->type_size(1)->allow_extra_args(false);
    };
    several(c.journal->add_option("--on", a.on, "switch a layer on"), "NAME");
    several(c.journal->add_option("--off", a.off, "switch a layer off: its stamps stay, and do nothing"), "NAME");
    several(c.journal->add_option("--strength", a.strength, "how much of a layer applies, 0 to 1"), "NAME=SHARE");
    several(c.journal->add_option("--move", a.move, "move a layer to a place, 0 for the bottom"), "NAME=PLACE");
    several(c.journal->add_option("--remove", a.remove, "remove a layer with its stamps"), "NAME");
    c.journal->add_flag("--compact", a.compact, "write only what still counts");
    c.journal->add_option("--stamps", a.stamps_out, "write the stamps that apply, in order, as JSON for --edits");
    c.journal->add_option("--json", a.json_path, "a summary for scripts; - for standard output");
    c.journal->add_flag("--quiet", a.quiet, "no summary: only what is wrong");
    c.rebase = app.add_subcommand("rebase", "carry a journal over to another pack of the same ground");
    c.rebase->add_option("JOURNAL", a.from, "the journal")->required();
    c.rebase->add_option("PACK", a.pack, "the pack that it is to belong to")->required();
    c.rebase->add_option("-o,--output", a.rebased, "the journal to write (default PACK.journal)");
    return c;
}

int run_journal(const JournalArguments& a) {
    const io::PackFile pack(a.pack);
    const std::string path = journal_of(a);
    io::refuse_overwriting({a.stamps_out, a.json_path}, {a.pack, path, a.stamps});
    const bool extend = changes(a);
    Journal journal(path, pack.pack().header, extend ? io::JournalAccess::extend : io::JournalAccess::read);
    std::optional<io::AtomicFile> stamps; // opened before anything changes
    if (!a.stamps_out.empty()) stamps.emplace(a.stamps_out);
    JsonOutput summary(a.json_path);
    if (journal.dropped_bytes() != 0)
        fmt::print(stderr, "fjell-bake: {}: left out {} bytes of an incomplete record at its end\n", path,
                   journal.dropped_bytes());
    if (extend) change(journal, a);
    if (stamps) {
        std::vector<io::TimedStamp> all;
        for (io::KeptStamp& stamp : journal.stamps()) all.push_back({0, std::move(stamp)});
        if (all.empty()) throw Failure(1, path + ": no stamp of it applies, and a file of stamps needs one");
        const std::string text = io::write_stamps(all);
        stamps->write(std::as_bytes(std::span(text)));
        stamps->commit();
    }
    summary.write(journal_json(journal));
    if (!a.quiet && a.json_path != "-") print(journal);
    return 0;
}

int run_rebase(const JournalArguments& a) {
    const std::string to = a.rebased.empty() ? io::journal_path(a.pack) : a.rebased;
    io::refuse_overwriting({to}, {a.from, a.pack});
    io::rebase_journal(a.from, io::PackFile(a.pack).pack().header, to);
    return 0;
}

} // namespace fjell::baker
