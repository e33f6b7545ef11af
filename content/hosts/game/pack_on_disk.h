// A pack that stays on the disk: its header, directory and corners in memory, the rest read when it is wanted.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <fjell/fjell.h>

namespace game {

class PackOnDisk {
public:
    PackOnDisk() = default;
    ~PackOnDisk();
    PackOnDisk(const PackOnDisk&) = delete;
    PackOnDisk& operator=(const PackOnDisk&) = delete;

    // Empty, or one line that says what is wrong.
    [[nodiscard]] std::string open(const char* path);
    // All of the bytes from there on. False: the disk failed, or the file ends before. Any thread.
    [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> to) const;

    [[nodiscard]] const fjell::Pack& pack() const { return pack_; }
    [[nodiscard]] std::span<const std::byte> corners() const { return corners_; }

private:
    int file_ = -1;
    std::vector<std::byte> directory_, corners_;
    fjell::Pack pack_; // points into directory_
};

} // namespace game
