#include "fjell/io/pack_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/set_file.h"
#include "io/set_parts.h"
#include "io/system.h"

namespace fjell::io {

std::string chunk_name(ChunkId id) {
    const auto of_tile = [&](std::string what) {
        what += ' ';
        what += std::to_string(id.item);
        what += " of tile ";
        return what += std::to_string(id.tile);
    };
    switch (id.kind) {
    case ChunkKind::corners: return "corners";
    case ChunkKind::geometry: return of_tile("page");
    case ChunkKind::colour: return of_tile("colour mip");
    case ChunkKind::normal: return of_tile("normal mip");
    case ChunkKind::horizon: return of_tile("horizon mip");
    case ChunkKind::layers: return "names of layers";
    case ChunkKind::splat: return of_tile("splat mip");
    case ChunkKind::crs: break;
    }
    return "CRS";
}

std::vector<std::string> layer_names(std::string_view text) {
    std::vector<std::string> names;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        names.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return names;
}

namespace {

// Somebody who names a folder means a set: what makes one of it is not to be seen from outside.
void refuse_folder(const std::string& path) {
    os::FileInfo info;
    if (!os::look(path, info) || info.kind != os::FileKind::folder) return;
    throw Failure(1, path + ": is a folder without a set.json, which would make it a pack set; give a pack or a set's "
                            "folder, make a set with fjell-bake split PACK -o FOLDER, or run the merge or split into "
                            "it again if it was interrupted");
}

} // namespace

PackFile::PackFile(const std::string& path) : path_(path) {
    if (const std::string set = set_file_of(path); !set.empty()) {
        open_set_file(set);
        return;
    }
    refuse_folder(path);
    fd_ = open_regular_file(path);
    try {
        open_pack_file();
    } catch (...) {
        os::close_file(fd_);
        throw;
    }
}

PackFile::~PackFile() {
    if (fd_ >= 0) os::close_file(fd_);
}

std::size_t PackFile::packs() const {
    return set_ ? set_->packs() : 1;
}

void PackFile::open_set_file(const std::string& set_file) {
    set_ = std::make_unique<SetParts>(set_file);
    const SetIndex& index = set_->index();
    file_bytes_ = index.file_bytes;
    require(open_index(index.header, index.directory, file_bytes_, pack_), path_);
    corners_.assign(index.corners.begin(), index.corners.end());
    read_crs();
}

void PackFile::open_pack_file() {
    os::FileInfo info;
    if (!os::look(fd_, info)) disk_failure(path_, "read");
    file_bytes_ = info.bytes;
    std::byte head[sizeof(PackHeader)];
    const std::span header = std::span(head).first(std::min<std::uint64_t>(sizeof head, file_bytes_));
    if (const int error = read(0, header); error != 0) fail(error);
    PackHeader h;
    require(read_header(header, file_bytes_, h), path_);
    if (h.tiles_held != 0) require({StatusCode::wrong_version, "version"}, path_); // of sets in memory
    directory_.resize(directory_bytes(h)); // no more than the file has: read_header has seen to it
    if (const int error = read(h.directory_offset, directory_); error != 0) fail(error);
    require(open_index(header, directory_, file_bytes_, pack_), path_);
    corners_ = stored({ChunkKind::corners, 0, 0});
    read_crs();
}

void PackFile::read_crs() {
    const PackHeader& h = pack_.header;
    crs_.resize(h.crs_bytes);
    if (crs_.empty()) return;
    const ChunkId crs{ChunkKind::crs, 0, 0};
    const Status s =
        decode_chunk(pack_.entry(chunk_index(h, crs)), stored(crs), std::as_writable_bytes(std::span(crs_)));
    if (!s.ok()) require({s.code, "CRS"}, path_);
}

std::vector<std::byte> PackFile::stored(ChunkId id) const {
    const ChunkEntry entry = pack_.entry(chunk_index(pack_.header, id));
    std::vector<std::byte> bytes(entry.stored_bytes);
    if (const int error = read(entry.offset, bytes); error != 0) fail(error);
    return bytes;
}

void PackFile::read_chunk(ChunkId id, std::vector<std::byte>& raw) const {
    const ChunkEntry entry = pack_.entry(chunk_index(pack_.header, id));
    raw.resize(entry.raw_bytes);
    if (decode_chunk(entry, stored(id), raw).ok()) return;
    if (changed()) fail(EIO);
    throw Failure(1, path_ + ": " + chunk_name(id) + ": " + message(StatusCode::corrupt));
}

bool PackFile::changed() const noexcept {
    if (set_) return set_->changed();
    const PackHeader& opened = pack_.header;
    os::FileInfo info;
    if (!os::look(fd_, info)) return false; // then the disk is at fault
    if (info.bytes != file_bytes_) return true;
    if (pack_.directory == nullptr) return false; // it is being opened
    std::byte head[sizeof(PackHeader)];
    return read(0, head) == 0 && std::memcmp(head, &opened, sizeof opened) != 0;
}

void PackFile::fail(int error) const {
    const std::string at_fault = set_        ? set_->what_changed()
                                 : changed() ? path_ + ": was changed after it was opened; open it again"
                                             : "";
    if (!at_fault.empty()) throw Failure(1, at_fault);
    errno = error;
    disk_failure(path_, "read");
}

int PackFile::read(std::uint64_t offset, std::span<std::byte> to) const noexcept {
    return set_ ? set_->read(offset, to) : os::read_at(fd_, offset, to);
}

void PackFile::drop_cache() const noexcept {
    if (set_) return set_->drop_cache();
    os::drop_cache(fd_);
}

} // namespace fjell::io
