// Packs that another program changes while ours have them open. When is counted in calls
// (support/fault_interposer.cpp), so nothing here depends on time.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <string>

#include "system/bake_faults.h"

using namespace fjell::test;

namespace {

const std::string baker_tool = FJELL_BIN_DIR "/fjell-bake ", fly_tool = FJELL_BIN_DIR "/fjell-fly ";

// A pack of 2 x 2 tiles with maps, and another of the same size.
class TwoPacks {
public:
    TwoPacks() {
        for (const char* name : {"one", "two"}) {
            spit(folder.path / (std::string(name) + ".json"), std::string(R"({"columns": 129, "rows": 129, "seed": )") +
                                                                  (name[0] == 'o' ? "7" : "8") +
                                                                  R"(, "spacing_m": 60, "relief_m": 2500})");
            REQUIRE(run(baker_tool + name + ".json -o " + name + " --tile 64 --quiet").code == 0);
        }
    }
    [[nodiscard]] Run run(const std::string& command) const { return run_in(folder.path, command); }
    // With the change at that read of p.fjell, or as soon as it is closed.
    [[nodiscard]] Run run(const std::string& command, const std::string& what, const std::string& when) const {
        for (const char* name : {"p.fjell", "p.fjell.new"})
            std::filesystem::copy_file(folder.path / (name[7] ? "two" : "one"), folder.path / name,
                                       std::filesystem::copy_options::overwrite_existing);
        return run(with({"pread,close", what, when, "p.fjell"}, command));
    }
    TemporaryFolder folder;
};

const TwoPacks& two_packs() {
    static const TwoPacks packs;
    return packs;
}

} // namespace

TEST_CASE("a pack that shrinks, is rewritten or fails while it is read ends a program with one line, not a signal") {
    const TwoPacks& place = two_packs();
    const std::string verify = baker_tool + "verify p.fjell", heights = baker_tool + "heights p.fjell -o h.tif",
                      fly = fly_tool + "p.fjell --headless --frames 2 --stream on --wait --error-px 1 --export 1:x.glb";
    const struct {
        const std::string& command;
        const char *what, *when;
    } changes[] = {{verify, "shrink", "1"},   {verify, "shrink", "6"}, {verify, "rewrite", "6"}, {verify, "EIO", "6+"},
                   {heights, "rewrite", "6"}, {fly, "shrink", "6"},    {fly, "rewrite", "9"},    {fly, "EIO", "9+"}};
    for (const auto& [command, what, when] : changes) {
        const Run r = place.run(command, what, when);
        CAPTURE(command, what, when, r.err);
        const bool disk = what == std::string("EIO");
        CHECK(r.code == (disk ? 3 : 1));
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK(r.err.find(disk ? "Input/output error" : "p.fjell: was changed after it was opened") !=
              std::string::npos);
    }
}

TEST_CASE("a pack that another is renamed over is read to its end, as it was") {
    const TwoPacks& place = two_packs();
    const std::string flight = "p.fjell --headless --frames 2 --stream on --wait --verify 1 --error-px 1 --export 1:";
    for (const auto& [start, name] :
         {std::pair{baker_tool + "heights p.fjell -o ", "h.tif"}, {fly_tool + flight, "h.glb"}}) {
        const std::string command = start + name;
        const Run undisturbed = place.run(command, "none", "1");
        const std::string whole = slurp(place.folder.path / name);
        REQUIRE(!whole.empty());
        CAPTURE(command, undisturbed.err);
        REQUIRE(undisturbed.code == 0);
        const Run r = place.run(command, "replace", "6");
        CAPTURE(r.err);
        CHECK(r.code == 0);
        // Of a flight its length alone: what streams in first stands first in the mesh. --verify measures it.
        const std::string written = slurp(place.folder.path / name);
        CHECK(written.size() == whole.size());
        if (command.starts_with(baker_tool)) CHECK((written == whole));
        CHECK(slurp(place.folder.path / "p.fjell") == slurp(place.folder.path / "two"));
    }
}
