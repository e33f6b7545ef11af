// What a snapshot does when it cannot be written: one line, the right exit code, nothing half-written left behind.
#include <catch2/catch.hpp>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <sys/resource.h>

#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "gltf/baked.h"

using namespace fjell;
using namespace fjell::test;

namespace {

const baker::BakeOptions& small() {
    static const baker::BakeOptions options = [] {
        baker::BakeOptions o;
        o.tile_log2 = 5;
        o.max_texture_log2 = 5;
        return o;
    }();
    return options;
}

// Files larger than this cannot be written while it lives: what a full disk looks like without one.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit now{bytes, before_.rlim_max};
        handler_ = std::signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &now);
    }
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
    rlimit before_{};
    void (*handler_)(int) = nullptr;
};

struct Fixture {
    Folder folder;
    BakedTerrain baked{folder, hills(97, 65, 30, 30), small()};
    View view = view_of(baked.terrain);
    std::vector<std::string> before = folder.names();

    gltf::SnapshotCounts write(const std::string& path, const gltf::SnapshotOptions& options = {}) const {
        return gltf::export_snapshot(baked.pack, baked.terrain, view, 2, path, options);
    }
    template <typename Write>
    void require_refused(const Write& write, int exit_code, const std::string& word) const {
        std::string message;
        try {
            write();
        } catch (const io::Failure& failure) {
            message = failure.what();
            CHECK(failure.exit_code == exit_code);
        }
        INFO(message);
        CHECK(message.find(word) != std::string::npos);
        CHECK(message.find('\n') == std::string::npos);
        CHECK(folder.names() == before);
    }
};

} // namespace

TEST_CASE("a snapshot into a folder that is missing is refused", "[gltf]") {
    const Fixture f;
    f.require_refused([&] { f.write(f.folder / "missing/out.glb"); }, 1, "folder does not exist");
    f.require_refused([&] { f.write(f.folder / "terrain.fjell/out.glb"); }, 1, "folder does not exist");
    f.require_refused([&] { f.write(f.folder / "."); }, 1, "is a folder");
    f.require_refused([&] { f.write(""); }, 2, "no file name");
    f.require_refused([&] { f.write(f.folder / "out.gltf"); }, 2, "ends in .glb");
}

TEST_CASE("a full disk leaves nothing behind and the older file as it was", "[gltf]") {
    Fixture f;
    {
        const FileSizeLimit limit(4096);
        f.require_refused([&] { f.write(f.folder / "out.glb"); }, 3, "cannot write");
    }
    if (std::filesystem::exists("/dev/full")) f.require_refused([&] { f.write("/dev/full"); }, 3, "free some space");
    f.write(f.folder / "out.glb");
    f.before = f.folder.names();
    const auto size = std::filesystem::file_size(f.folder / "out.glb");
    const FileSizeLimit limit(4096);
    f.require_refused([&] { f.write(f.folder / "out.glb"); }, 3, "cannot write");
    CHECK(std::filesystem::file_size(f.folder / "out.glb") == size);
}

TEST_CASE("a snapshot larger than glTF allows is refused and says what to ask for", "[gltf]") {
    const Fixture f;
    const auto size = gltf::export_snapshot(f.baked.pack, f.baked.terrain, f.view, 2, "/dev/null").file_bytes;
    REQUIRE(size > 10'000);
    for (const std::uint64_t limit : {std::uint64_t{0}, std::uint64_t{5000}, size - 1})
        f.require_refused([&] { f.write(f.folder / "out.glb", {.max_file_bytes = limit}); }, 1, "larger error_px");
    CHECK(f.write(f.folder / "out.glb", {.max_file_bytes = size}).file_bytes == size);
}

TEST_CASE("a snapshot of something else than a mesh of this terrain is refused", "[gltf]") {
    const Fixture f;
    const MeshVertex vertices[] = {{0, 0, 0}, {0, 32, 0}, {32, 32, 0}, {33, 0, 0}};
    const std::uint32_t indices[] = {0, 1, 2, 0, 1, 3, 0, 1, 9, 0, 0, 1};
    const auto write = [&](std::vector<TileRange> tiles, bool lagging = false) {
        const MeshView mesh{Topology::triangles, vertices, indices, tiles};
        return gltf::write_snapshot(f.baked.pack, f.baked.terrain, mesh, {.view = f.view, .lagging = lagging},
                                    f.folder / "out.glb");
    };
    f.require_refused([&] { write({{0, 3, 3, 1}}); }, 2, "out of range");
    f.require_refused([&] { write({{0, 6, 3, 1}}); }, 2, "out of range");
    f.require_refused([&] { write({{0, 9, 6, 1}}); }, 2, "range");
    f.require_refused([&] { write({{6, 0, 3, 1}}); }, 2, "range");
    f.require_refused([&] { write({{0, 9, 3, 1}}); }, 2, "no triangle");
    f.require_refused([&] { write({}); }, 2, "turn it");
    f.require_refused([&] { write({}, true); }, 2, "take a later frame"); // where turning the camera would not help
    CHECK(write({{0, 0, 3, 1}}).triangles == 1);
}

TEST_CASE("a snapshot with numbers that make no sense is refused", "[gltf]") {
    Fixture f;
    f.require_refused([&] { gltf::export_snapshot(f.baked.pack, f.baked.terrain, f.view, 0, f.folder / "out.glb"); }, 2,
                      "error_px");
    f.require_refused([&] { gltf::export_snapshot(f.baked.pack, f.baked.terrain, f.view, -1, f.folder / "out.glb"); },
                      2, "error_px");
    f.view.top = 2000;
    f.require_refused([&] { f.write(f.folder / "out.glb"); }, 2, "View::bottom, top");
}

TEST_CASE("a pack whose colour is corrupt is refused", "[gltf]") {
    const Fixture f;
    std::vector<std::byte> bytes(f.baked.pack.bytes.begin(), f.baked.pack.bytes.end());
    bytes[f.baked.pack.entry(chunk_index(f.baked.pack.header, {ChunkKind::colour, 3, 0})).offset] ^= std::byte{1};
    Pack pack = f.baked.pack;
    pack.bytes = bytes;
    f.require_refused([&] { gltf::export_snapshot(pack, f.baked.terrain, f.view, 2, f.folder / "out.glb"); }, 1,
                      "colour mip 0 of tile 3: the pack is damaged");
}
