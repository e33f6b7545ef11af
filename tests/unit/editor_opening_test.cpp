// Packs that a thread reads while another terrain is shown: in quick succession, damaged, with a graphics context that
// is lost meanwhile, and with a bake that ends. Needs a headless OpenGL context.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "editor/engine.h"
#include "editor/handlers/handlers.h"
#include "fjell/gl/context.h"
#include "fjell/io/failure.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

struct OpeningPlace {
    OpeningPlace() {
        context = gl::Headless::create();
        Random random(31);
        for (const char* name : {"a.fjell", "b.fjell", "c.fjell"})
            (void)baker::bake(random_dem(random, 90, 70, Shape::fractal), small_bake(4), folder / name);
        std::ofstream(folder / "damaged.fjell") << "FJELLPK\n and nothing else";
        engine.open(folder / "a.fjell", state.document.profile());
    }
    ~OpeningPlace() { // before its context goes
        engine.abandon_opening();
        engine.drop_graphics();
        engine.close();
    }
    void begin(const std::string& name) { engine.begin_opening(folder / name, state); }
    // As frames do, until nothing is read any more; what finish_opening() gave last.
    std::string until_open() {
        std::string pack;
        while (engine.opening()) {
            if (engine.opening_done())
                pack = engine.finish_opening();
            else
                std::this_thread::yield();
        }
        return pack;
    }
    [[nodiscard]] std::string shown() const {
        return std::filesystem::path(engine.session().file->path()).filename().string();
    }

    TemporaryFolder folder;
    std::unique_ptr<gl::Headless> context;
    State state;
    Engine engine;
    Jobs jobs;
};

} // namespace

TEST_CASE("of packs that are opened in quick succession the latest is shown, and the others never") {
    OpeningPlace place;
    const std::uint64_t before = place.engine.terrains();
    place.begin("b.fjell");
    place.begin("damaged.fjell");
    place.begin("c.fjell");
    CHECK(place.until_open() == place.folder / "c.fjell");
    CHECK(place.shown() == "c.fjell");
    CHECK(place.engine.terrains() == before + 1);
    place.begin("damaged.fjell"); // whose failure nobody wants to know any more
    place.begin("b.fjell");
    CHECK(place.until_open() == place.folder / "b.fjell");
}

TEST_CASE("a pack that cannot be opened leaves what is shown, and the next one opens") {
    OpeningPlace place;
    const std::uint64_t before = place.engine.terrains();
    place.begin("damaged.fjell");
    CHECK_THROWS_AS(place.until_open(), io::Failure);
    CHECK_FALSE(place.engine.opening());
    CHECK(place.shown() == "a.fjell");
    CHECK(place.engine.terrains() == before);
    place.begin("b.fjell");
    CHECK(place.until_open() == place.folder / "b.fjell");
}

TEST_CASE("a pack that is being opened outlives the graphics context, and so does one that waits for it") {
    OpeningPlace place;
    place.begin("b.fjell");
    place.engine.drop_graphics();
    place.engine.make_graphics();
    CHECK(place.until_open() == place.folder / "b.fjell");
    place.begin("c.fjell");
    place.begin("a.fjell");
    place.engine.drop_graphics();
    place.engine.make_graphics();
    CHECK(place.until_open() == place.folder / "a.fjell");
    place.begin("damaged.fjell");
    place.engine.drop_graphics(); // which does not throw what reading has thrown
    place.engine.make_graphics();
    CHECK_THROWS_AS(place.until_open(), io::Failure);
    CHECK(place.shown() == "a.fjell");
}

TEST_CASE("a pack whose opening is abandoned is not shown, nor the one that waits behind it") {
    OpeningPlace place;
    place.begin("b.fjell");
    place.begin("c.fjell");
    place.engine.abandon_opening();
    CHECK_THROWS_AS(place.until_open(), io::Failure);
    CHECK(place.shown() == "a.fjell");
    place.begin("b.fjell"); // and is destroyed while it reads
}

TEST_CASE("a bake that ends while another pack is being opened takes nothing from it: the user decides") {
    OpeningPlace place;
    const HandlerContext context{place.state, place.engine, place.jobs};
    for (const bool asks : {false, true}) {
        place.state.opening = place.folder / "b.fjell";
        place.begin("b.fjell");
        place.state.bake.asks = asks;
        place.state.interface.dialog = Dialog::bake;
        take_baked(place.folder / "c.fjell", context);
        CHECK(place.state.interface.dialog == Dialog::baked);
        CHECK(place.state.bake.ready == place.folder / "c.fjell");
        CHECK(place.until_open() == place.folder / "b.fjell");
        place.state.opening.clear();
    }
}
