// The profile being tuned: undoing, dragging, what an engine refuses, saving.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "editor/document.h"
#include "editor/panels/tune.h"
#include "fjell/io/failure.h"
#include "support/program.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::editor;
using test::slurp;
using test::spit;
using test::TemporaryFolder;

namespace {

const fjell::ProfileKey& key_of(const char* name) {
    const fjell::ProfileKey* const key = fjell::find_profile_key(name);
    REQUIRE(key != nullptr);
    return *key;
}

// What a document promises, without its economies: every profile there was, in full.
struct Model {
    std::vector<fjell::Profile> past, future;
    fjell::Profile now, saved;

    void change_to(const fjell::Profile& to) {
        if (same(to, now)) return;
        past.push_back(now);
        now = to;
        future.clear();
    }
    void undo() {
        if (past.empty()) return;
        future.push_back(now);
        now = past.back();
        past.pop_back();
    }
    void redo() {
        if (future.empty()) return;
        past.push_back(now);
        now = future.back();
        future.pop_back();
    }
};

void require_like(const Document& document, const Model& model) {
    REQUIRE(same(document.profile(), model.now));
    REQUIRE(same(document.saved(), model.saved));
    REQUIRE(document.undo_steps() == model.past.size());
    REQUIRE(document.redo_steps() == model.future.size());
    REQUIRE(document.unsaved() == !same(model.now, model.saved));
}

// Documents and models, through the same random hands.
class Hands {
public:
    explicit Hands(std::uint64_t seed) : random_(seed) { document.save(folder_ / "0.toml"); }

    void do_something() {
        switch (random_() % 8) {
        case 0:
        case 1: return type();
        case 2: return drag();
        case 3: document.undo(), model.undo(); return;
        case 4: document.redo(), model.redo(); return;
        case 5: return save();
        case 6: return open();
        default: return replace();
        }
    }

    Document document;
    Model model;

private:
    const fjell::ProfileKey& any_key() {
        for (;;) {
            const fjell::ProfileKey& key = fjell::profile_keys()[random_() % fjell::profile_keys().size()];
            const std::string name = key.name;
            if (name != "metric" && name != "cull") return key; // which may refuse one another
        }
    }
    // Few different ones, so that they come back often.
    double any_value(const fjell::ProfileKey& key) { return slider_value(key, static_cast<double>(random_() % 4) / 3); }
    fjell::Profile with(fjell::Profile profile, const fjell::ProfileKey& key, double value) {
        if (key.get(profile) != value) key.set(profile, value);
        return profile;
    }
    // held: not into that one, which would be the end of its drag and no step of its own.
    void type(const fjell::ProfileKey* held = nullptr) {
        const fjell::ProfileKey* chosen = &any_key();
        while (chosen == held) chosen = &any_key();
        const fjell::ProfileKey& key = *chosen;
        const double value = any_value(key);
        document.set(key, value, false);
        model.change_to(with(model.now, key, value));
    }
    void drag() {
        const fjell::ProfileKey& key = any_key();
        fjell::Profile to = model.now;
        for (auto moves = 1 + random_() % 4; moves != 0; --moves) {
            const double value = any_value(key);
            document.set(key, value, true);
            to = with(to, key, value);
            REQUIRE(same(document.profile(), to));
        }
        const bool dragged = document.dragging();
        switch (random_() % 4) {
        case 0: // undone while it is held, which goes on until it is let go
            model.change_to(to);
            document.undo();
            model.undo();
            if (!dragged) break;
            document.set(key, any_value(key), true);
            break;
        case 1: // and something else is typed meanwhile
            model.change_to(to);
            type(&key);
            return;
        default: model.change_to(to);
        }
        document.set(key, key.get(document.profile()), false);
        REQUIRE(!document.dragging());
    }
    void save() {
        document.save(folder_ / std::to_string(random_() % 3) + ".toml");
        model.saved = model.now;
        files_[document.path()] = model.now;
    }
    void open() {
        if (files_.empty()) return;
        auto file = files_.begin();
        std::advance(file, static_cast<std::ptrdiff_t>(random_() % files_.size()));
        document.open(file->first);
        const fjell::Profile read = fjell::read_profile(file->first);
        REQUIRE(same(read, file->second));
        model = {{}, {}, read, read}; // undo ends where the file was opened
    }
    void replace() {
        const fjell::Profile other = random_() % 2 == 0 ? fjell::Profile{} : with({}, key_of("refine.max_error_px"), 3);
        document.replace(other);
        model.change_to(other);
    }

    TemporaryFolder folder_;
    std::map<std::string, fjell::Profile> files_;
    std::mt19937_64 random_;
};

} // namespace

TEST_CASE("whatever is set, dragged, undone, redone, opened and saved, a document is what a model of it is") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        INFO("seed " << seed);
        Hands hands(seed);
        for (int i = 0; i < 60; ++i) {
            hands.do_something();
            require_like(hands.document, hands.model);
        }
        while (hands.document.undo_steps() > 0) hands.document.undo(), hands.model.undo();
        require_like(hands.document, hands.model);
        while (hands.document.redo_steps() > 0) hands.document.redo(), hands.model.redo();
        require_like(hands.document, hands.model);
    }
}

TEST_CASE("what an engine refuses is reverted with all its steps, and what was saved meanwhile stays saved") {
    for (std::uint64_t seed = 101; seed <= 120; ++seed) {
        INFO("seed " << seed);
        Hands hands(seed);
        for (int i = 0; i < 20; ++i) {
            hands.document.accept();
            const Model accepted = hands.model;
            const std::string path = hands.document.path();
            for (int k = 0; k < 3; ++k) hands.do_something();
            hands.document.revert();
            const fjell::Profile saved = hands.document.saved();
            hands.model = accepted;
            hands.model.saved = saved;
            require_like(hands.document, hands.model);
            if (hands.document.path() == path) continue;
            REQUIRE(same(fjell::read_profile(hands.document.path()), saved)); // it was saved there
        }
        REQUIRE(!hands.document.revert()); // nothing since
    }
}

TEST_CASE("an open that an engine refuses leaves the file that was there before") {
    const TemporaryFolder folder;
    Document document;
    document.save(folder / "mine.toml");
    document.accept();
    spit(folder / "theirs.toml", "# Of another.\n#\n[budget]\nvertices = 4096\n");
    document.open(folder / "theirs.toml");
    REQUIRE(document.path() == folder / "theirs.toml");
    REQUIRE(document.revert());
    CHECK(document.path() == folder / "mine.toml");
    CHECK(document.heading().empty());
    CHECK_FALSE(document.unsaved());
    CHECK(document.undo_steps() == 0);
}

TEST_CASE("undo ends where a file was opened: what was before is never saved under its name") {
    const TemporaryFolder folder;
    spit(folder / "laptop.toml", "[refine]\nmax_error_px = 4.0\n");
    Document document;
    document.set(key_of("refine.max_error_px"), 9, false);
    document.open(folder / "laptop.toml");
    CHECK(document.undo_steps() == 0);
    document.undo();
    CHECK(document.profile().refine.max_error_px == 4);
    CHECK_FALSE(document.unsaved());
    document.set(key_of("refine.max_error_px"), 5, false);
    document.undo();
    CHECK(document.profile().refine.max_error_px == 4);
    CHECK(document.redo_steps() == 1);
    document.open(folder / "laptop.toml");
    CHECK(document.redo_steps() == 0);
}

TEST_CASE("what was saved before an engine refused it is saved still") {
    const TemporaryFolder folder;
    Document document;
    document.save(folder / "a.toml");
    document.accept();
    document.set(key_of("refine.max_error_px"), 3, false);
    document.save(folder / "b.toml");
    REQUIRE(document.revert());
    CHECK(document.path() == folder / "b.toml");
    CHECK(document.saved().refine.max_error_px == 3);
    CHECK(document.profile().refine.max_error_px == 1);
    CHECK(document.unsaved());
}

TEST_CASE("a drag is one step, and none when it ends where it began") {
    Document document;
    const fjell::ProfileKey& key = key_of("refine.max_error_px");
    for (const double value : {1.5, 2.0, 4.0}) document.set(key, value, true);
    CHECK(document.dragging());
    CHECK(document.undo_steps() == 1);
    document.set(key, 4.0, false);
    CHECK(std::string(document.undo_label()) == key.label);
    document.undo();
    CHECK(key.get(document.profile()) == 1.0);
    CHECK(std::string(document.redo_label()) == key.label);
    for (const double value : {3.0, 2.0, 1.0}) document.set(key, value, true);
    document.set(key, 1.0, false);
    CHECK(document.undo_steps() == 0);
    CHECK(document.redo_steps() == 1); // as if nothing had been done since
}

TEST_CASE("an undo while a control is held is not undone by the hand that still holds it") {
    Document document;
    const fjell::ProfileKey& key = key_of("refine.max_error_px");
    document.set(key, 5, true);
    document.undo();
    CHECK_FALSE(document.dragging()); // the engine may follow
    CHECK(document.held() == &key);
    document.set(key, 6, true);
    document.set(key, 6, false);
    CHECK(key.get(document.profile()) == 1.0);
    document.set(key, 6, true);
    CHECK(key.get(document.profile()) == 6.0);
}

TEST_CASE("values that do not go together are refused in one line and change nothing") {
    Document document;
    document.set(key_of("refine.cull"), 0, false);
    const auto steps = document.undo_steps();
    CHECK_THROWS_WITH(document.set(key_of("refine.metric"), 1, false), Catch::Contains("refine.cull"));
    CHECK(document.profile().refine.metric == Metric::isotropic);
    CHECK(document.undo_steps() == steps);
}

TEST_CASE("a profile keeps the heading of the file it came from, saved there or elsewhere") {
    const TemporaryFolder folder;
    const std::string from = FJELL_SOURCE_DIR "/profiles/laptop.toml";
    Document document;
    document.open(from);
    document.set(key_of("refine.max_error_px"), 7, false);
    document.save(folder / "mine.toml");
    const std::string text = slurp(folder / "mine.toml");
    const std::string heading = fjell::profile_heading(slurp(from));
    REQUIRE(!heading.empty());
    CHECK(fjell::profile_heading(text) == heading);
    CHECK(fjell::parse_profile(text, "mine").refine.max_error_px == 7);
    CHECK(document.path() == folder / "mine.toml");
    CHECK_FALSE(document.unsaved());
}

// Run as root, any folder can be written: a file in the place of the folder, a folder in the place of the file and a
// device that is full stand in for one that may not be.
TEST_CASE("a profile that cannot be saved stays unsaved, and what was there stays as it was") {
    const TemporaryFolder folder;
    spit(folder / "file", "not a folder");
    std::filesystem::create_directory(folder / "folder.toml");
    Document document;
    document.save(folder / "mine.toml");
    const std::string before = slurp(folder / "mine.toml");
    document.set(key_of("refine.max_error_px"), 7, false);
    for (const std::string& path :
         {folder / "file/mine.toml", folder / "folder.toml", std::string("/dev/full"), folder / "missing/mine.toml"}) {
        INFO(path);
        CHECK_THROWS_AS(document.save(path), io::Failure);
        CHECK(document.unsaved());
        CHECK(document.path() == folder / "mine.toml");
        CHECK(slurp(folder / "mine.toml") == before);
    }
    CHECK(folder.names() == std::vector<std::string>{"file", "folder.toml", "mine.toml"});
    CHECK_THROWS_WITH(Document().save(""), Catch::Contains("where"));
}

TEST_CASE("a bad profile is refused in one line and nothing has changed") {
    const TemporaryFolder folder;
    Document document;
    document.set(key_of("refine.max_error_px"), 7, false);
    const auto version = document.version();
    spit(folder / "bad.toml", "[refine]\nmax_error_px = -1\n");
    spit(folder / "worse.toml", "{");
    for (const char* name : {"bad.toml", "worse.toml", "missing.toml"}) {
        INFO(name);
        CHECK_THROWS_AS(document.open(folder / name), io::Failure);
        CHECK_THROWS_AS(document.compare(folder / name), io::Failure);
        CHECK(document.version() == version);
        CHECK(document.compared() == nullptr);
    }
}

TEST_CASE("restored changes are one step away from the file they were made to, or unsaved where that is gone") {
    const TemporaryFolder folder;
    fjell::Profile changed;
    changed.refine.max_error_px = 9;
    spit(folder / "file.toml", "# Mine.\n\n[refine]\nmax_error_px = 3.0\n");
    Document document;
    document.restore(changed, folder / "file.toml");
    CHECK(document.unsaved());
    CHECK(document.profile().refine.max_error_px == 9);
    CHECK(document.saved().refine.max_error_px == 3);
    CHECK(document.heading() == "Mine.");
    document.undo(); // to what the file has
    CHECK(document.profile().refine.max_error_px == 3);
    CHECK_FALSE(document.unsaved());
    CHECK(document.undo_steps() == 0);
    Document gone;
    gone.restore(changed, folder / "gone.toml");
    CHECK(gone.unsaved());
    gone.save("");
    CHECK(fjell::read_profile(folder / "gone.toml").refine.max_error_px == 9);
}

TEST_CASE("a slider reaches both ends of every key exactly, never falls, and says where a value lies") {
    bool times = false;
    for (const fjell::ProfileKey& key : fjell::profile_keys()) {
        INFO(key.table << '.' << key.name);
        CHECK(slider_value(key, 0) == key.least);
        CHECK(slider_value(key, 1) == key.most);
        CHECK(slider_share(key, key.least) == 0);
        CHECK(slider_share(key, key.most) == Approx(1));
        double last = key.least;
        for (int i = 0; i <= 1000; ++i) {
            const double value = slider_value(key, i / 1000.0);
            REQUIRE(value >= last);
            REQUIRE(value <= key.most);
            if (key.kind != fjell::KeyKind::number) REQUIRE(value == std::round(value));
            // The slider of that value gives that value: holding it still changes nothing.
            REQUIRE(slider_value(key, slider_share(key, value)) == Approx(value).epsilon(0.006));
            last = value;
        }
        char text[64];
        for (const double value : {key.least, slider_value(key, 0.5), key.most}) {
            write_value(key, value, text, sizeof text);
            double read = -1;
            REQUIRE(typed_value(key, text, read));
            CHECK(read == Approx(value).epsilon(1e-6));
        }
        if (std::string(key.unit) == "us") { // shown and typed in milliseconds, as all times of the window
            write_value(key, 16667, text, sizeof text);
            CHECK(std::string(text) == "16.667");
            double read = -1;
            REQUIRE(typed_value(key, "16.667", read));
            CHECK(read == 16667);
            REQUIRE(typed_value(key, "0.043", read));
            CHECK(read == 43); // 0.043 / 1e-3 is a little less
            times = true;
        }
        double untouched = 5;
        for (const char* word : {"", "x", "1 2", "nan", "inf", "1px"}) CHECK_FALSE(typed_value(key, word, untouched));
        CHECK(untouched == 5);
    }
    CHECK(times);
}
