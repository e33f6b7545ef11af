// Opening files and packs, and what file dialogs list.
#include <filesystem>

#include <fmt/format.h>

#include "editor/files/file_kind.h"
#include "editor/files/persistence.h"
#include "editor/files/sample.h"
#include "editor/handlers/handlers.h"
#include "editor/jobs/factories.h"
#include "fjell/io/failure.h"

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

} // namespace

void handle(const BrowseFolder& c, HandlerContext context) {
    Files& files = context.state.files;
    files.browser.look(c.folder);
}

void handle(const BrowseFor& c, HandlerContext context) {
    Files& files = context.state.files;
    std::string folder = files.browser.folder();
    if (folder.empty()) folder = files.settings.folder.empty() ? "." : files.settings.folder;
    std::error_code ignored;
    if (!c.beside.empty())
        if (const fs::path above = fs::absolute(c.beside, ignored).parent_path(); fs::is_directory(above, ignored))
            folder = above.string();
    files.browser.filter(c.filter, false);
    files.browser.look(folder);
}

void handle(const BrowseAllKinds& c, HandlerContext context) {
    FolderListing& browser = context.state.files.browser;
    browser.filter(browser.kinds(), c.on);
}

void handle(const OpenFile& c, HandlerContext context) {
    State& state = context.state;
    switch (file_kind_of(c.path)) {
    case FileKind::pack:
        // A frame that waits is seen in a window that shows something already.
        if (!state.headless && state.frame != 0) {
            context.engine.begin_opening(c.path, state);
            state.opening = c.path;
            return;
        }
        return open_now(c.path, context);
    case FileKind::profile: return handle(OpenProfile{c.path, c.discard}, context);
    case FileKind::path:
        if (!context.engine.is_open())
            throw io::Failure(2, fmt::format("{}: this is a camera path; open a terrain for it first", c.path));
        return handle(OpenPath{c.path, c.discard}, context);
    case FileKind::heights:
        if (state.headless) return bake_beside(c.path, context); // nobody is there to fill in a dialog
        return handle(GiveBakeFile{c.path, BakeField::none, state.interface.dialog == Dialog::bake}, context);
    }
}

void open_now(const std::string& pack, HandlerContext context) {
    context.engine.open(pack, context.state.document.profile());
    show_opened(pack, context);
}

void show_opened(const std::string& pack, HandlerContext context) {
    context.state.document.accept();
    start_at_scene(context);
    remember_pack(pack, context.state);
    State& state = context.state;
    std::error_code unknown;
    std::string absolute = fs::absolute(pack, unknown).lexically_normal().string();
    if (absolute == state.bookmarks.pack) return;
    state.bookmarks.pack = std::move(absolute);
    state.runs = {}; // of another terrain
    state.compared = {};
}

void bake_beside(const std::string& heights, HandlerContext context) {
    BakePack bake;
    bake.inputs = {heights};
    bake.output = pack_beside(heights);
    std::error_code ignored;
    if (fs::exists(bake.output, ignored))
        throw io::Failure(
            2, fmt::format("{}: exists already; open that pack, or bake elsewhere: --do \"bake {} OTHER.fjell\"",
                           bake.output, heights));
    handle(bake, context);
}

void handle(const OpenSample&, HandlerContext context) {
    const std::string& folder = context.state.files.standard_folders.cache;
    const std::string pack = sample_pack(folder);
    std::error_code ignored;
    if (fs::exists(pack, ignored)) {
        try {
            return handle(OpenFile{pack, true}, context);
        } catch (const io::Failure& failure) { // of another version, or damaged: it is recreated
            post_message(context.state, Severity::note, fmt::format("the sample is baked again: {}", failure.what()));
        }
    }
    handle(bake_sample(folder), context);
}

} // namespace fjell::editor
