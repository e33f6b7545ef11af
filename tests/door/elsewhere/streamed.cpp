// streamed PACK SET FOLDER: opens a pack by a name that is not ASCII, with a profile, streams it with two threads and
// prints what its meshes hash to; then a set of packs, files that are missing, and files that are replaced while they
// are open. Prints the same on every system. FOLDER: a new one, for its files.
#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "fjell/io.h"
#include "fjell/profile.h"
#include "io/file.h"
#include "io/system.h"

using namespace fjell;

namespace {

// Order does not count: pages arrive as they like.
std::uint64_t hash_of(const MeshView& mesh) {
    std::uint64_t sum = 0;
    for (const TileRange& range : mesh.tiles)
        for (std::uint32_t i = range.first_index; i + 2 < range.first_index + range.index_count; i += 3) {
            const auto corners = mesh.indices.subspan(i, 3);
            std::array<std::uint64_t, 3> hashes{};
            for (std::size_t k = 0; k < 3; ++k) {
                const MeshVertex& v = mesh.vertices[corners[k]];
                std::uint64_t h = 14695981039346656037u;
                for (const std::uint32_t part :
                     {std::uint32_t(v.column), std::uint32_t(v.row), std::bit_cast<std::uint32_t>(v.height_m)})
                    h = (h ^ part) * 1099511628211u;
                hashes[k] = h;
            }
            if (hashes[0] == hashes[1] || hashes[1] == hashes[2] || hashes[2] == hashes[0]) continue; // degenerate
            std::sort(hashes.begin(), hashes.end());
            sum += hashes[0] * 3 ^ hashes[1] * 5 ^ hashes[2] * 7;
        }
    return sum;
}

void fly(const char* what, const std::string& pack, const Profile& profile) {
    io::LiveTerrain ground(pack, live_options(profile));
    const double wide_m = ground.terrain().extent_x_m(), deep_m = ground.terrain().extent_z_m(),
                 high_m = static_cast<double>(ground.pack().header.max_m);
    double now_s = 0;
    for (int place = 0; place < 5; ++place) {
        View view;
        view.eye_m = {wide_m * place / 4, high_m + 50, deep_m * (4 - place) / 8};
        const io::LiveFrame* frame = nullptr;
        do {
            frame = &ground.update({&view, 1}, now_s += 1.0 / 64);
            std::this_thread::yield();
        } while (!frame->converged);
        std::printf("%s, place %d: %016" PRIx64 ", %" PRIu32 " triangles\n", what, place, hash_of(frame->mesh.mesh),
                    frame->cut.triangles);
    }
    std::printf("%s: %s, read %s\n", what, ground.first_failure().empty() ? "no failure" : "failures",
                ground.reader().pages > 0 ? "by pages" : "nothing");
}

void write(const std::string& path, std::span<const std::byte> bytes) {
    io::AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

// What a failure says, of a file in the folder. Systems have words of their own for one errno.
template <typename Call>
void tell(const std::string& folder, const Call& call) {
    try {
        call();
        std::printf("no failure\n");
    } catch (const io::Failure& failure) {
        std::string said = failure.what();
        if (const auto at = said.find(folder); at != std::string::npos) said.erase(at, folder.size());
        std::printf("%d: %s\n", failure.exit_code, said.c_str());
    }
}

int run(const std::string& pack, const std::string& set, const std::string& root) {
    const std::string folder = root + "/H\xc3\xb6hen \xe5\x9c\xb0\xe5\xbd\xa2/", // UTF-8, as everywhere
        ours = folder + "\xd0\xb3\xd0\xbe\xd1\x80\xd0\xb0.fjell", toml = folder + "k\xc3\xb8ln.toml";
    std::filesystem::create_directories(io::os::path_of(folder));
    const std::vector<std::byte> bytes = io::read_file(pack);
    write(ours + ".fjell-tmp", {}); // as a program that was killed has left it
    write(ours, bytes);
    std::printf("left: %d\n", std::filesystem::exists(io::os::path_of(ours + ".fjell-tmp")));
    const std::string text = "[refine]\nmax_error_px = 2.5\n[stream]\ndecoders = 2\n";
    write(toml, std::as_bytes(std::span(text)));

    Profile profile = read_profile(toml);
    std::printf("profile: %g px\n", live_options(profile).settings.cut.max_error_px);
    set_profile_key(profile, "stream.page_slots", "4096");
    fly("file", ours, profile);
    fly("set", set, profile);
    tell(folder, [&] { (void)read_profile(folder + "no.toml"); });
    tell(folder, [&] { const io::LiveTerrain none(folder + "no.fjell"); });
    tell(folder, [&] { const io::LiveTerrain none(folder + "no/no.fjell"); });
    tell(root, [&] { const io::LiveTerrain none(root); });
    tell(folder, [&] { write(folder + "no/new.fjell", bytes); });

    const io::PackFile open(ours);
    {
        io::AtomicFile given_up(ours);
        given_up.write(std::as_bytes(std::span(text)));
    }
    std::printf("given up: %s\n", io::read_file(ours) == bytes ? "as before" : "lost");
    write(ours, std::as_bytes(std::span(text)));
    std::vector<std::byte> old(bytes.size());
    const bool kept = open.read(0, old) == 0 && old == bytes && !open.changed();
    std::printf("replaced: who has it open %s\n", kept ? "keeps it" : "lost it");
    tell(folder, [&] { const io::LiveTerrain none(ours); });
    write(ours, bytes);
    std::printf("replaced again: %s\n", io::load_pack(ours, io::LoadTerrain::yes).file == bytes ? "whole" : "broken");
    std::printf("past the end: %s\n", open.read(bytes.size() - 1, std::span(old).first(2)) == EIO ? "EIO" : "read");
    tell(folder, [&] {
        io::refuse_overwriting({ours}, {folder + "../" + folder.substr(root.size() + 1) + ours.substr(folder.size())});
    });
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return io::run_tool("streamed", [&] {
        if (argc != 4) throw io::Failure(2, "usage: streamed PACK SET FOLDER");
        return run(argv[1], argv[2], argv[3]);
    });
}
