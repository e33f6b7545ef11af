// Heights of a source by cells of 32 x 32 samples, read where they are asked for: along lines, never a whole terrain.
//
// Thread: one at a time. Memory: 4 bytes a sample of the cells that were asked for; io::Failure 1 beyond
// most_edited_samples, which a bake of the changed ground refuses, too.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "baker/read/source.h"

namespace fjell::baker {

inline constexpr std::int32_t ground_cell = 32; // samples a side; as the runtime keeps what has been edited

class GroundCells {
public:
    // name: for messages.
    GroundCells(const HeightSource& source, std::string name);

    // Reads the cells that these samples lie in, in the order that is fastest: before they are asked for one by one.
    struct Sample {
        std::int32_t x, y;
    };
    void load(std::span<const Sample> samples);
    // NaN: a hole, or outside.
    [[nodiscard]] float at(std::int32_t x, std::int32_t y);
    // Between samples; NaN where one of the four is a hole.
    [[nodiscard]] double between(double column, double row);

    [[nodiscard]] std::int32_t columns() const { return columns_; }
    [[nodiscard]] std::int32_t rows() const { return rows_; }

private:
    using Cell = std::vector<float>;
    [[nodiscard]] Cell& made(std::int32_t cx, std::int32_t cy);
    void read(const Window& window);

    std::string name_;
    std::int32_t columns_, rows_;
    std::unique_ptr<HeightReader> reader_;
    std::unordered_map<std::uint64_t, Cell> cells_;
    std::vector<float> window_;
};

} // namespace fjell::baker
