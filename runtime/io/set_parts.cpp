#include "io/set_parts.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/file.h"

namespace fjell::io {

namespace {

// A pack of the set as its index needs it; its file is closed again.
struct OpenedPart {
    std::vector<std::byte> header, directory, corners;
    Pack pack;
};

void read_index(const std::string& path, OpenedPart& part) {
    const PackFile file(path); // says what is wrong with it
    const PackHeader& h = file.pack().header;
    const auto read = [&](std::uint64_t offset, std::size_t bytes) {
        std::vector<std::byte> to(bytes);
        if (const int error = file.read(offset, to); error != 0) file.fail(error);
        return to;
    };
    part.header = read(0, sizeof(PackHeader));
    part.directory = read(h.directory_offset, static_cast<std::size_t>(directory_bytes(h)));
    part.corners.assign(file.corners().begin(), file.corners().end());
    require(open_index(part.header, part.directory, h.file_bytes, part.pack), path);
}

void check_named(const SetFile& set, const SetFilePack& named, const PackHeader& h, const std::string& path,
                 const std::string& set_path) {
    const auto other = [&](const std::string& what) {
        throw Failure(1,
                      path + ": " + what + " than " + set_path + " says; copy the pack again, or write the set again");
    };
    if (named.has_hash && named.pack_hash != h.directory_hash) other("another pack (pack_hash)");
    if (named.tiles_x != h.tiles_x || named.tiles_y != h.tiles_y) other("other numbers of tiles");
    if (set.tile_cells != 1u << h.tile_log2) other("another tile size");
    for (const int axis : {0, 1})
        if (!(std::abs(set.spacing_m[axis] / h.spacing_m[axis] - 1) < 1e-12)) other("another spacing");
}

} // namespace

SetParts::SetParts(const std::string& set_path) : SetParts(parse_set_file(read_text(set_path), set_path), set_path) {}

SetParts::SetParts(const SetFile& set, const std::string& set_path) {
    const std::filesystem::path folder = os::path_of(set_path).parent_path();
    const std::string folder_path = folder.empty() ? "." : os::text_of(folder);
    if (const int error = folder_.open(folder_path); error != 0) errno = error, disk_failure(folder_path, "open");
    std::vector<std::unique_ptr<OpenedPart>> opened;
    std::vector<SetPart> parts;
    std::uint64_t begins = sizeof(PackHeader);
    for (const SetFilePack& named : set.packs) {
        const std::string path = os::text_of(folder / os::path_of(named.file));
        auto& part = *opened.emplace_back(std::make_unique<OpenedPart>());
        std::error_code none;
        if (!std::filesystem::exists(os::path_of(path), none))
            throw Failure(1, path + ": a pack of " + set_path + " is missing; copy it there, or write the set again");
        if (!set_file_of(path).empty())
            throw Failure(1, path + ": a set in the set " + set_path + "; name its packs in one set.json");
        read_index(path, part);
        const PackHeader& h = part.pack.header;
        check_named(set, named, h, path, set_path);
        parts.push_back({&part.pack, part.corners, named.tile_x, named.tile_y});
        parts_.push_back({path, named.file, begins, h.file_bytes, h.header_hash});
        begins += h.file_bytes;
    }
    const SetShape shape{set.columns, set.rows};
    const std::size_t bytes = std::max<std::size_t>(set_index_bytes(shape, parts), 1);
    memory_ = allocate(bytes);
    std::uint32_t at_fault = 0;
    const Status s = make_set_index(shape, parts, {memory_.get(), bytes}, index_, at_fault);
    if (s.ok()) return;
    const std::string where = at_fault < parts_.size() ? parts_[at_fault].path : set_path;
    if (s.code == StatusCode::wrong_pack && std::string_view(s.field).starts_with("corners"))
        throw Failure(1, where + ": " + s.field + ": not those of the packs beside it; the packs of a set must be of " +
                             "one bake: fjell-bake join " + folder_path + " compares their borders");
    if (s.code == StatusCode::wrong_pack)
        throw Failure(1, where + ": " + s.field + ": not that of " + parts_.front().path +
                             "; the packs of a set must be of one bake");
    if (s.code == StatusCode::out_of_range)
        throw Failure(1, where + ": " + s.field + ": does not fit " + set_path + "; write the set again");
    require(s, where);
}

SetParts::~SetParts() {
    for (const Part& part : parts_)
        if (part.fd >= 0) os::close_file(part.fd);
}

void SetParts::close_one() noexcept {
    Part* oldest = nullptr;
    for (Part& part : parts_)
        if (part.fd >= 0 && part.readers == 0 && (oldest == nullptr || part.used < oldest->used)) oldest = &part;
    if (oldest == nullptr) return; // as many threads read as there may be descriptors: one more, then
    os::close_file(std::exchange(oldest->fd, -1));
    --open_;
}

int SetParts::compare(int fd, const Part& part) noexcept {
    PackHeader h;
    os::FileInfo info;
    if (!os::look(fd, info)) return errno;
    if (info.bytes != part.bytes) return os::stale_error;
    if (const int error = os::read_at(fd, 0, std::as_writable_bytes(std::span(&h, 1))); error != 0) return error;
    return h.header_hash == part.header_hash ? 0 : os::stale_error;
}

int SetParts::acquire(Part& part) noexcept {
    const std::lock_guard hold(lock_);
    if (part.fd < 0) {
        if (open_ >= most_set_descriptors) close_one();
        int fd = folder_.open_to_read(part.file);
        if (fd < 0 && (errno == EMFILE || errno == ENFILE)) { // with fewer, then
            close_one();
            fd = folder_.open_to_read(part.file);
        }
        if (fd < 0) return errno;
        if (const int error = compare(fd, part); error != 0) {
            os::close_file(fd);
            return error;
        }
        part.fd = fd;
        ++open_;
    }
    part.used = ++clock_;
    ++part.readers;
    return 0;
}

void SetParts::release(Part& part) noexcept {
    const std::lock_guard hold(lock_);
    --part.readers;
}

int SetParts::read_part(Part& part, std::uint64_t offset, std::span<std::byte> to) noexcept {
    if (const int error = acquire(part); error != 0) return error;
    const int error = os::read_at(part.fd, offset, to);
    release(part);
    return error;
}

int SetParts::read(std::uint64_t offset, std::span<std::byte> to) noexcept {
    const auto copy = [&](std::span<const std::byte> from, std::uint64_t at) {
        const std::size_t n = std::min<std::uint64_t>(to.size(), from.size() - at);
        std::memcpy(to.data(), from.data() + at, n);
        return n;
    };
    while (!to.empty()) {
        std::size_t done = 0;
        if (offset < index_.header.size()) {
            done = copy(index_.header, offset);
        } else if (offset >= index_.tail_offset) {
            if (offset - index_.tail_offset >= index_.tail.size()) return EIO;
            done = copy(index_.tail, offset - index_.tail_offset);
        } else {
            const auto after = std::upper_bound(parts_.begin(), parts_.end(), offset,
                                                [](std::uint64_t at, const Part& part) { return at < part.begins; });
            Part& part = *std::prev(after);
            done = static_cast<std::size_t>(std::min<std::uint64_t>(to.size(), part.begins + part.bytes - offset));
            if (const int error = read_part(part, offset - part.begins, to.first(done)); error != 0) return error;
        }
        to = to.subspan(done);
        offset += done;
    }
    return 0;
}

const SetParts::Part* SetParts::first_changed(int& error) noexcept {
    for (Part& part : parts_) {
        error = acquire(part);
        if (error == 0) {
            error = compare(part.fd, part);
            release(part);
        }
        if (error == ENOENT || error == EACCES || error == os::stale_error) return &part;
    }
    return nullptr;
}

bool SetParts::changed() noexcept {
    int error = 0;
    return first_changed(error) != nullptr;
}

std::string SetParts::what_changed() {
    int error = 0;
    const Part* const part = first_changed(error);
    if (part == nullptr) return {};
    if (error == ENOENT)
        return part->path + ": is gone since its set was opened; copy it there, and open the set again";
    if (error == EACCES) return part->path + ": may not be read any more; make it readable, and open the set again";
    return part->path + ": was changed after it was opened; open it again";
}

void SetParts::drop_cache() noexcept {
    for (Part& part : parts_) {
        if (acquire(part) != 0) continue;
        os::drop_cache(part.fd);
        release(part);
    }
}

} // namespace fjell::io
