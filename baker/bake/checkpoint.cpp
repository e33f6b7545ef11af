#include "baker/bake/checkpoint.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <span>
#include <type_traits>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <xxhash.h>

#include "fjell/pack.h"
#include "io/file.h"

namespace fjell::baker {

struct Checkpoint::Stored {
    char magic[8];
    std::array<std::uint64_t, 2> identity;
    CheckpointState state;
    std::uint64_t hash; // XXH3 of all before
};

namespace {

constexpr char magic[8] = {'F', 'J', 'E', 'L', 'L', 'W', 'K', '3'};

// Another build may cut the work, or compute, differently.
std::string program() {
    struct stat info {};
    if (stat("/proc/self/exe", &info) != 0) return {};
    return fmt::format("{} {}.{:09}", info.st_size, info.st_mtim.tv_sec, info.st_mtim.tv_nsec);
}

std::string start_of_machine() {
    std::ifstream file("/proc/sys/kernel/random/boot_id");
    std::string id;
    std::getline(file, id);
    return id;
}

} // namespace

void CheckpointState::note_source(const SourceProperties& source, bool voids) {
    has_voids = voids;
    holes = voids && source.holes;
    native_quantum_m = source.native_quantum_m;
    anchor_m = source.anchor_m;
    lowest = source.lowest;
    highest = source.highest;
}

Checkpoint::Checkpoint(std::string path, const std::string& identity) : path_(std::move(path)) {
    static_assert(std::is_trivially_copyable_v<CheckpointState>, "CheckpointState is stored as it is");
    const std::string all = identity + '\n' + start_of_machine() + '\n' + program() + '\n' +
                            std::to_string(pack_layout_hash) + '\n' + std::to_string(sizeof(Stored));
    const XXH128_hash_t hash = XXH3_128bits(all.data(), all.size());
    identity_ = {hash.low64, hash.high64};
    if (path_.empty()) return;
    std::ifstream file(path_, std::ios::binary);
    std::array<char, sizeof(Stored) + 1> bytes;
    file.read(bytes.data(), bytes.size());
    if (file.gcount() != static_cast<std::streamsize>(sizeof(Stored))) return;
    Stored found{};
    std::memcpy(static_cast<void*>(&found), bytes.data(), sizeof found);
    if (std::memcmp(found.magic, magic, sizeof magic) != 0 || found.identity != identity_ ||
        found.hash != XXH3_64bits(bytes.data(), offsetof(Stored, hash)))
        return;
    state = found.state;
    resumed_ = true;
}

Checkpoint::Stored Checkpoint::stored() const {
    Stored s;
    std::memset(static_cast<void*>(&s), 0, sizeof s); // padding too: it is hashed
    std::memcpy(s.magic, magic, sizeof magic);
    s.identity = identity_;
    std::memcpy(static_cast<void*>(&s.state), static_cast<const void*>(&state), sizeof state);
    s.hash = XXH3_64bits(&s, offsetof(Stored, hash));
    return s;
}

void Checkpoint::set_complete(StageId id) {
    state.complete = id.number() + 1;
    write();
}

void Checkpoint::write() {
    if (path_.empty()) return;
    const Stored bytes = stored();
    const std::string temporary = path_ + ".new";
    const int fd =
        io::uninterrupted([&] { return open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666); });
    if (fd < 0) io::disk_failure(temporary, "open");
    try {
        io::write_all(fd, 0, std::as_bytes(std::span(&bytes, 1)), temporary);
    } catch (...) {
        close(fd);
        throw;
    }
    if (close(fd) != 0) io::disk_failure(temporary, "close");
    if (rename(temporary.c_str(), path_.c_str()) != 0) io::disk_failure(path_, "rename");
}

} // namespace fjell::baker
