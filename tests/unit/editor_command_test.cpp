// Commands as text: what scripts say and --help-commands lists.
#include <catch2/catch.hpp>

#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "editor/command.h"
#include "fjell/io/failure.h"

using namespace fjell;
using namespace fjell::editor;

namespace {

// One that each verb takes, and some that it does not. Those of no words refuse any.
struct Use {
    std::vector<std::string> good, bad;
};
const std::map<std::string, Use>& uses() {
    static const std::map<std::string, Use> all = {
        {"open", {{"a.fjell", "\"a b.fjell\" discard"}, {"", "a b", "a discard c"}}},
        {"sample", {{""}, {"x"}}},
        {"set",
         {{"refine.max_error_px 2", "refine.method recursive", "budget.max_work 0", "refine.cull false"},
          {"", "refine.max_error_px", "refine.max_error_px x", "refine.max_error_px -1", "error_px 2",
           "budget.vertices 1.5", "refine.method sometimes", "refine.max_error_px 2 3"}}},
        {"undo", {{""}, {"x"}}},
        {"redo", {{""}, {"x"}}},
        {"defaults", {{""}, {"x"}}},
        {"brush",
         {{"off", "raise", "crater radius=20 falloff=3 amount=5 strength=0.5", "lower amount=-3", "road radius=4",
           "paint colour=5c4e3c material=3", "unpaint", "lock radius=4 error=0.05", "lock error=0", "unlock"},
          {"", "shovel", "raise 20", "raise radius=0", "paint colour=red", "paint colour=5c4e3c0", "paint material=16",
           "paint material=1.5", "raise strength=2", "raise amount=wide", "raise depth=1", "lock error=-1",
           "lock error=wide"}}},
        {"stroke", {{"1 2", "1 2 3 4.5 -6 7"}, {"", "1", "1 2 3", "1 x"}}},
        {"edit-layer",
         {{"add pits", "choose 0", "remove 2", "on 0", "off 1", "strength 1 0.5", "move 0 1"},
          {"", "add", "choose", "choose x", "on -1", "strength 0", "strength 0 2", "move 1", "hide 0", "off 0 0"}}},
        {"open-profile", {{"a.toml", "a.toml discard"}, {"", "a.toml b"}}},
        {"save-profile", {{"", "a.toml"}, {"a b"}}},
        {"compare", {{"", "a.toml"}, {"a b"}}},
        {"compare-off", {{""}, {"x"}}},
        {"browse", {{"", "/tmp"}, {"a b"}}},
        {"browse-all", {{"on", "off"}, {"", "yes"}}},
        {"go-on", {{"save", "discard", "cancel"}, {"", "perhaps", "save save"}}},
        {"recover", {{"restore", "discard"}, {"", "perhaps"}}},
        {"bake",
         {{"a.tif b.fjell", "a.tif b.fjell tile=64 texture=t.png ramp=r.json spacing=30 zscale=2 zoffset=-3",
           "a.tif b.tif c.fjell tile=auto order=hz nodata=hole void=-9999,-999 crs=EPSG:25833 memory_mb=256"},
          {"", "a.tif", "a.tif b.fjell tile=x", "a.tif b.fjell tile=-1", "a.tif b.fjell sizes=1",
           "a.tif b.fjell spacing=wide"}}},
        {"bake-file", {{"a.tif", "a.tif another", "a.png texture"}, {"", "a.tif somewhere", "a.tif heights heights"}}},
        {"open-baked", {{"on", "off"}, {"", "yes"}}},
        {"camera", {{"1 2 3 0 -20"}, {"", "1 2 3 0", "1 2 3 0 x", "1 2 3 0 0 0", "1 2 inf 0 0"}}},
        {"jump", {{"1 2"}, {"", "1", "1 x", "1 2 3"}}},
        {"home", {{""}, {"x"}}},
        {"speed", {{"100"}, {"", "fast", "1 2"}}},
        {"navigate", {{"fly", "orbit", "path"}, {"", "swim"}}},
        {"freeze", {{"on", "off"}, {"", "maybe", "on on"}}},
        {"open-path", {{"a.json", "a.json discard"}, {"", "a b"}}},
        {"save-path", {{"", "a.json"}, {"a b"}}},
        {"record-path", {{"on", "off"}, {""}}},
        {"play-path", {{"on", "off"}, {"", "x"}}},
        {"seek-path", {{"0", "0.5", "1"}, {"", "2", "-1", "x"}}},
        {"add-point", {{""}, {"1"}}},
        {"replace-point", {{"0"}, {"", "-1", "1.5", "x"}}},
        {"remove-point", {{"3"}, {"", "-1"}}},
        {"select-point", {{"3", "3 stay"}, {"", "x", "3 go"}}},
        {"insert-point", {{"", "0.5"}, {"2", "x", "0 1"}}},
        {"move-point", {{"3 0"}, {"", "3", "3 x", "1 2 3"}}},
        {"restore-path", {{""}, {"x"}}},
        {"path-seconds", {{"30", "0"}, {"", "x", "1 2"}}},
        {"loop-path", {{"on", "off"}, {"", "x"}}},
        {"clear-path", {{""}, {"x"}}},
        {"probe", {{"0.5 0.25", "0 1"}, {"", "0.5", "2 0", "x 0", "0 0 0"}}},
        {"mark", {{"100 200"}, {"", "100", "x 1", "1 2 3"}}},
        {"remove-mark", {{""}, {"x"}}},
        {"clear-marks", {{""}, {"x"}}},
        {"contours", {{"auto", "20", "0.5"}, {"", "0", "x", "1 2"}}},
        {"use-tuned", {{""}, {"x"}}},
        {"mode", {{"shaded", "levels"}, {"", "pretty"}}},
        {"overlay", {{"wireframe on", "culled off"}, {"", "wireframe", "clouds on"}}},
        {"panel", {{"tune", "levels", "auto-tune"}, {"", "none"}}}, // levels: a former one
        {"group", {{"cost.time on", "light.sun off"}, {"", "cost.time", "cost.sound on"}}},
        {"light", {{"relief", "dusk"}, {"", "disco"}}},
        {"materials", {{"none", "built-in alpine", "a.fjell-materials", "a.fjell-materials b.json"}, {"", "a b c"}}},
        {"dialog", {{"none", "start", "recover"}, {"", "chat"}}},
        {"float", {{"cost on", "auto-tune off"}, {"", "cost", "clock on", "cost on on"}}},
        {"place-panel",
         {{"cost 1 2 300 400", "cost -20 0 180 180"}, {"", "cost 1 2 3", "cost 1 2 3 4", "cost 1 -2 300 400"}}},
        {"scale", {{"0.5", "2"}, {"", "0", "100", "x"}}},
        {"interface",
         {{"panels off", "picture-only on", "panel-keys on", "half-resolution off"}, {"", "panels", "sound on"}}},
        {"column",
         {{"left width 300", "right split 0.4", "left folded on"},
          {"", "left", "left width", "left width 10", "middle folded on", "left folded 1", "left split 2"}}},
        {"frame-report", {{"0", "12", "off"}, {"", "x", "512", "-1", "1 2"}}},
        {"hold-graphs", {{"on", "off"}, {"", "x"}}},
        {"zoom-graphs", {{"100 20", "511 0"}, {"", "100", "512 0", "x 0", "1 2 3"}}},
        {"dismiss", {{""}, {"x"}}},
        {"tune",
         {{"", "measure=frame budget_us=3000 frames=100 least_px=0.5 most_px=8",
           "apply=yes also=yes csv=a.csv frames=0"},
          {"measure=sound", "budget_us=x", "frames=1.5", "frames=-3", "speed=1", "budget_us", "apply=maybe", "also=1",
           "budget_us=1"}}},
        {"benchmark", {{"a.csv", "a.csv 100"}, {"", "a.csv x", "a.csv -1"}}},
        {"export",
         {{"a.glb", "a.glb 2", "a.glb converged", "a.glb texel_m=5", "a.glb 2 texel_m=0",
           "a.glb quantised=yes meshopt=no texture=jpeg"},
          {"", "a.glb x", "a.glb converged 2", "a.glb texel_m=-1", "a.glb quantised=1", "a.glb texture=webp"}}},
        {"preview", {{"", "2", "converged", "texel_m=5", "quantised=no meshopt=yes texture=png"}, {"x", "size=3"}}},
        {"cancel", {{""}, {"x"}}},
        {"screenshot", {{"a.png", "a.png terrain"}, {"", "a.png sky"}}},
        {"resize", {{"640 480"}, {"", "640", "1 1", "640 x", "100000 100000"}}},
        {"dump", {{"a.json"}, {"", "a b"}}},
        {"lose-graphics", {{""}, {"x"}}},
        {"frames", {{"3"}, {"", "-1", "x"}}},
        {"wait", {{""}, {"x"}}},
        {"quit", {{"", "discard"}, {"x", "discard discard"}}},
        {"run-place", {{"0 0.5", "7 1"}, {"", "0", "x 0", "0 2", "0 0 0"}}},
        {"forget-run", {{"0"}, {"", "x", "-1"}}},
        {"heat", {{"none", "time", "error"}, {"", "warm"}}},
        {"render", {{"a.png", "a.png width=64 height=36"}, {"", "a.png sideways", "a.png width=8"}}},
        {"place-point", {{"0 100 200", "0 100 200 900"}, {"", "0", "0 1", "x 1 2", "0 1 2 y"}}},
        {"add-bookmark", {{"", "valley"}, {"a b"}}},
        {"bookmark", {{"0"}, {"", "x"}}},
        {"remove-bookmark", {{"0"}, {"", "x"}}},
        {"compare-picture", {{"off", "profile", "4"}, {"", "x", "-1", "4 5"}}},
        {"compare-view", {{"split", "difference"}, {"", "both"}}},
        {"divider", {{"0", "0.5"}, {"", "2", "x"}}},
    };
    return all;
}

// Those that --help-commands lists: lines that are not indented.
std::set<std::string> listed() {
    std::set<std::string> verbs;
    std::istringstream lines(command_help());
    for (std::string line; std::getline(lines, line);)
        if (!line.starts_with(' ')) verbs.insert(line.substr(0, line.find(' ')));
    return verbs;
}

} // namespace

TEST_CASE("every verb that the help lists takes its words, and others only with one line that says how it goes") {
    const std::set<std::string> verbs = listed();
    for (const std::string& verb : verbs) {
        INFO(verb);
        const auto use = uses().find(verb);
        REQUIRE(use != uses().end()); // a verb was added: say above how it is used
        for (const std::string& words : use->second.good) {
            INFO(words);
            CHECK(parse_command(verb + " " + words).has_value());
        }
        for (const std::string& words : use->second.bad) {
            INFO(words);
            try {
                (void)parse_command(verb + " " + words);
                FAIL_CHECK("was taken");
            } catch (const io::Failure& failure) {
                const std::string line = failure.what();
                CHECK(failure.exit_code == 2);
                CHECK(line.find('\n') == std::string::npos);
                CHECK(line.starts_with(verb + ": "));
                CHECK(line.find("usage: " + verb) != std::string::npos);
            }
        }
    }
    for (const auto& [verb, use] : uses()) CHECK(verbs.count(verb) == 1);
}

TEST_CASE("every kind of command but those of a hand on the camera or in a form has a text form") {
    std::set<std::size_t> kinds;
    for (const auto& [verb, use] : uses())
        for (const std::string& words : use.good) kinds.insert(parse_command(verb + " " + words)->index());
    for (const Command& by_hand :
         {Command(MoveCamera{}), Command(DraftBake{}), Command(BrowseFor{}), Command(AimBrush{})})
        CHECK(kinds.count(by_hand.index()) == 0);
    CHECK(kinds.size() + 4 == std::variant_size_v<AnyCommand>);
}

TEST_CASE("commands carry what their words say") {
    const auto parsed = [](const char* line) { return *parse_command(line); };
    const SetKey set = std::get<SetKey>(parsed("set refine.max_error_px 2.5"));
    CHECK(std::string(set.key->name) == "max_error_px");
    CHECK(set.value == 2.5);
    CHECK_FALSE(set.dragging);
    CHECK(std::get<SetKey>(parsed("set refine.method recursive")).value == 1);
    CHECK(std::get<OpenFile>(parsed("open \"a b.fjell\" discard")).path == "a b.fjell");
    CHECK(std::get<OpenFile>(parsed("open a discard")).discard);
    CHECK_FALSE(std::get<OpenFile>(parsed("open a")).discard);
    CHECK(std::get<AnswerUnsaved>(parsed("go-on discard")).answer == Answer::discard);
    CHECK(std::get<RecoverChanges>(parsed("recover restore")).restore);
    CHECK_FALSE(std::get<RecoverChanges>(parsed("recover discard")).restore);
    CHECK_FALSE(std::get<TakeScreenshot>(parsed("screenshot a.png terrain")).with_panels);
    CHECK(std::get<Quit>(parsed("quit discard")).discard);
    const BakePack bake = std::get<BakePack>(parsed("bake a.tif b.fjell tile=64 zscale=2"));
    CHECK(bake.inputs == std::vector<std::string>{"a.tif"});
    CHECK(bake.tile == 64);
    CHECK(bake.height_scale == 2);
}

TEST_CASE("empty lines and those that begin with # are no commands, and an unknown verb says where verbs are listed") {
    for (const char* line : {"", "   ", "# set refine.max_error_px 2", "\t\r"})
        CHECK_FALSE(parse_command(line).has_value());
    CHECK_THROWS_WITH(parse_command("fly me"), Catch::Contains("--help-commands"));
    CHECK_THROWS_WITH(parse_command("open \"a"), Catch::Contains("quote"));
}
