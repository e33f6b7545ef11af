// The files of a pack set that is open: found by an offset of the whole, a bounded number of them open at a time. They
// are opened again by their names in the folder as it was found, so that one that is moved, or a program that changes
// its working folder, does no harm.
//
// Thread: read() from any, several at once; a descriptor is opened, and the one that was used longest ago closed, under
// a lock that no read is held by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "fjell/io/load.h"
#include "fjell/pack_set.h"
#include "io/set_file.h"
#include "io/system.h"

namespace fjell::io {

inline constexpr std::size_t most_set_descriptors = 32;

class SetParts {
public:
    // set_file: the path of set.json. Throws Failure: 1 for a set, or a pack of it, that is missing, damaged or not
    // the one that the set names; 3 for a disk that fails.
    explicit SetParts(const std::string& set_file);
    // The same of an index that is not in a file, or not yet. set_file: where it would be.
    SetParts(const SetFile& set, const std::string& set_file);
    ~SetParts();
    SetParts(const SetParts&) = delete;
    SetParts& operator=(const SetParts&) = delete;

    [[nodiscard]] const SetIndex& index() const { return index_; }
    [[nodiscard]] std::size_t packs() const { return parts_.size(); }
    // 0, or what errno said; EIO where a file ends, os::stale_error for one that is another than when the set was
    // opened.
    [[nodiscard]] int read(std::uint64_t offset, std::span<std::byte> to) noexcept;
    // Of the first of its files that is not what it was: a line that names it and says what to do. Empty: of none. One
    // that cannot be looked at, because the machine has no descriptor left or the disk fails, has not changed.
    [[nodiscard]] std::string what_changed();
    [[nodiscard]] bool changed() noexcept; // whether there is one
    void drop_cache() noexcept;

private:
    struct Part {
        std::string path, file; // file: its name in the folder
        std::uint64_t begins = 0, bytes = 0, header_hash = 0;
        int fd = -1;
        std::uint32_t readers = 0;
        std::uint64_t used = 0; // when
    };
    // 0, os::stale_error for another file than the part was, or what errno said.
    [[nodiscard]] static int compare(int fd, const Part& part) noexcept;
    [[nodiscard]] const Part*
    first_changed(int& error) noexcept; // nullptr: none; error: ENOENT, EACCES or os::stale_error
    // 0 and a descriptor that stays until release(), or an errno.
    int acquire(Part& part) noexcept;
    void release(Part& part) noexcept;
    int read_part(Part& part, std::uint64_t offset, std::span<std::byte> to) noexcept;
    void close_one() noexcept; // that nobody reads; with the lock held

    os::Folder folder_;
    std::vector<Part> parts_;
    AlignedMemory memory_; // of the index
    SetIndex index_;
    std::mutex lock_; // of descriptors
    std::size_t open_ = 0;
    std::uint64_t clock_ = 0;
};

} // namespace fjell::io
