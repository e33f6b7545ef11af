// What the bulk pass does to a page's rows at once - slots, corners, fans and vertices -, against the plainest way to
// say the same, with vectors of every length that this machine has.
#include <catch2/catch.hpp>

#include <bit>
#include <cstring>
#include <memory>
#include <vector>

#include "bulk_rows.h"
#include "cut/bulk_rows.h"
#include "cut/evaluate.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Bits as the pass has them: most rows have none.
std::uint32_t random_row(Random& random) {
    return pick(random, 0, 2) == 0 ? random_bits(random) : 0;
}

void fill(Random& random, SlotGrid& grid, std::uint32_t vertices) {
    const auto slots = [&](auto& rows) {
        for (auto& row : rows)
            for (std::uint32_t& slot : row)
                slot = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(vertices) - 1));
    };
    slots(grid.corner), slots(grid.centre), slots(grid.side_x), slots(grid.side_y);
}

} // namespace

TEST_CASE("rows in use are those with a bit, and slots go to their lanes and nowhere else") {
    Random random(304);
    std::vector<std::uint32_t> stack(400);
    for (std::uint32_t& slot : stack) slot = static_cast<std::uint32_t>(pick(random, 0, 1 << 30));
    Mesh mesh{};
    mesh.free_vertices = stack.data();
    BulkPass bulk{};
    BulkPage page{};
    with_all_vectors([&] {
        for (int round = 0; round < 500; ++round) {
            // Of a coarse step a row is one group.
            const bool coarse = pick(random, 0, 3) == 0;
            const std::uint32_t width = coarse ? group_lanes : page_squares;
            for (std::uint32_t& row : page.active) row = random_row(random) & (coarse ? 0xffff : ~0u);
            bulk.free_before = static_cast<std::uint32_t>(pick(random, 0, 400)); // some in use before, some fresh
            bulk.fresh_before = bulk.free_before + 1000;
            page.number = static_cast<std::uint32_t>(pick(random, 0, 100));
            const NumberedRows rows{&page, static_cast<std::uint32_t>(pick(random, 0, 39)),
                                    static_cast<std::uint32_t>(pick(random, 0, 64))};
            std::uint32_t number = 0;
            for (std::uint32_t n = 0; n < bulk_rows; ++n) {
                page.first[n] = static_cast<std::uint16_t>(number);
                number += static_cast<std::uint32_t>(std::popcount(page.active[n]));
            }
            const std::uint32_t stride =
                coarse ? group_lanes : page_squares + static_cast<std::uint32_t>(pick(random, 0, 4));
            constexpr std::uint32_t untouched = 0xabcdef01;
            std::vector<std::uint32_t> plain(std::size_t{64} * stride, untouched), fast = plain;
            std::uint64_t used = 0;
            for (std::uint32_t n = 0; n < rows.count; ++n) {
                const std::uint32_t active = page.active[rows.first + n];
                used |= std::uint64_t{active != 0} << n;
                std::uint32_t next = page.number + page.first[rows.first + n];
                for (std::uint32_t lane = 0; lane < page_squares; ++lane) {
                    if (!(active >> lane & 1)) continue;
                    const bool free = next < bulk.free_before;
                    plain[n * stride + lane] =
                        free ? stack[bulk.free_before - 1 - next] : bulk.fresh_before + next - bulk.free_before;
                    ++next;
                }
            }
            REQUIRE(rows_in_use(page.active + rows.first, rows.count) == used);
            put_slots(BulkSlots(mesh, bulk), rows, fast.data(), stride);
            for (std::uint32_t n = 0; n < rows.count; ++n) // what becomes of the other lanes of a row is nobody's
                for (std::uint32_t lane = 0; lane < width; ++lane)
                    if (!(page.active[rows.first + n] >> lane & 1)) fast[n * stride + lane] = untouched;
            REQUIRE(fast == plain);
        }
    });
}

TEST_CASE("a finer page gets the corners that its squares need") {
    Random random(305);
    const auto from = std::make_unique<SlotGrid>(), to = std::make_unique<SlotGrid>();
    with_all_vectors([&] {
        for (int round = 0; round < 300; ++round) {
            fill(random, *from, 1 << 20);
            fill(random, *to, 1 << 20);
            const std::uint32_t half = 1u << pick(random, 0, 4);
            const auto places = static_cast<int>(page_squares / half) - 1;
            const std::uint32_t qx = half * static_cast<std::uint32_t>(pick(random, 0, places)),
                                qy = half * static_cast<std::uint32_t>(pick(random, 0, places));
            const std::uint32_t rows =
                random_bits(random) & static_cast<std::uint32_t>((std::uint64_t{1} << 2 * half) - 1);
            hand_down(*from, *to, qx, qy, half, rows);
            for (std::uint32_t y = 0; y <= 2 * half; ++y) {
                const std::uint64_t around = rows | std::uint64_t{rows} << 1;
                for (std::uint32_t x = 0; (around >> y & 1) != 0 && x <= 2 * half; ++x) {
                    const std::uint32_t i = qx + x / 2, j = qy + y / 2;
                    const std::uint32_t of = y % 2 == 0
                                                 ? (x % 2 == 0 ? from->corner[j][i] : from->side_x[j][i])
                                                 : (x % 2 == 0 ? from->side_y[j][i] : from->centre[j + 1][i + 1]);
                    REQUIRE(to->corner[y][x] == of);
                }
            }
        }
    });
}

TEST_CASE("fans of whole rows are those of their centres and sides one after the other") {
    Random random(306);
    const auto grid = std::make_unique<SlotGrid>();
    with_all_vectors([&] {
        std::uint32_t cut_short = 0;
        for (int round = 0; round < 300; ++round) {
            fill(random, *grid, Buffers::vertices);
            std::uint32_t centre[page_squares], side_x[page_squares + 1], west[2 * page_squares];
            std::uint64_t side_y[page_squares], finer[2 * page_squares + 2];
            for (std::uint32_t& row : centre) row = random_row(random);
            for (std::uint32_t& row : side_x) row = random_row(random);
            for (std::uint32_t& row : west) row = static_cast<std::uint32_t>(pick(random, 0, 1));
            for (std::uint64_t& row : side_y)
                row = random_row(random) | std::uint64_t{static_cast<std::uint32_t>(pick(random, 0, 1))}
                                               << page_squares;
            for (std::uint64_t& row : finer) row = random_bits(random) | std::uint64_t{random_bits(random)} << 32;
            const std::uint32_t rows = random_bits(random);
            Buffers fast, plain;
            fast.out.end = plain.out.end = static_cast<std::uint32_t>(pick(random, 0, Buffers::slots));
            const FanPage page{grid.get(), centre, side_x, side_y, finer, west, ~0u};
            const std::uint32_t left = fan_rows(fast.out, page, rows);
            for (std::uint32_t j = 0; j < page_squares; ++j) {
                if (!((rows & ~left) >> j & 1)) continue;
                const std::uint32_t *const up = grid->corner[j], *const down = grid->corner[j + 1],
                                           *const slots = grid->centre[j + 1] + 1;
                const auto columns = [&](std::uint32_t n) { return ~(finer[n + 1] << 1 | west[n]); };
                REQUIRE(fan_centres(plain.out, {slots, up, down, ~side_y[j], ~side_x[j], ~side_x[j + 1]}, centre[j]) ==
                        0);
                REQUIRE(fan_sides(plain.out,
                                  {grid->side_x[j], up, grid->centre[j] + 1, slots, ~finer[2 * j], ~finer[2 * j + 1]},
                                  side_x[j]) == 0);
                REQUIRE(fan_sides(plain.out, {grid->side_y[j], slots - 1, up, down, columns(2 * j), columns(2 * j + 1)},
                                  static_cast<std::uint32_t>(side_y[j])) == 0);
            }
            REQUIRE((left == 0 || (left & rows) == left));
            require_alike(fast, plain);
            cut_short += left != 0;
        }
        REQUIRE(cut_short > 50);
    });
}

TEST_CASE("vertices placed by rows are those placed one by one, and no slot after theirs is written") {
    Random random(307);
    const RadiusScale radii = RadiusScale::make();
    const ErrorScale errors = ErrorScale::make(0.01f, 1.05f, 1);
    std::uint32_t voids_seen = 0;
    with_all_vectors([&] {
        for (int round = 0; round < 200; ++round) {
            Criterion c{};
            c.error_m = errors.metres;
            c.radius_factor = radii.factor;
            c.base_m = -100, c.quantum_m = 0.01f, c.spacing_x_m = 30, c.spacing_z_m = 20;
            c.last_x = pick(random, 1, 5'000), c.last_y = pick(random, 1, 5'000); // some stand on the rim
            std::vector<VertexRecord> records(page_squares * (2 * page_squares + 3));
            for (VertexRecord& r : records)
                r = {static_cast<std::uint16_t>(pick(random, 0, 65535)),
                     static_cast<std::uint8_t>(pick(random, 0, 255)), static_cast<std::uint8_t>(pick(random, 0, 255))};
            std::uint32_t bits[2][page_squares + 1];
            for (auto& plane : bits)
                for (std::uint32_t& row : plane) row = random_row(random);
            const std::uint32_t first[2] = {0, page_squares * (page_squares + 1)};
            PageRows planes[2];
            PickedLanes one_by_one{
                records.data(),        nullptr, 0, pick(random, 0, 3'000), pick(random, 0, 3'000), pick(random, 0, 5),
                pick(random, 0, 1000), 40.0f};
            std::vector<std::uint64_t> picked;
            for (std::uint32_t n = 0; n < 2; ++n) {
                const std::uint32_t stride = page_squares + n, count = page_squares + 1 - n;
                // As sides_x and sides_y lie: half a square apart.
                const std::uint32_t east = 1 - n, south = n;
                planes[n] = {records.data() + first[n],
                             stride,
                             count,
                             bits[n],
                             one_by_one.x0 + static_cast<std::int32_t>(east << one_by_one.z),
                             one_by_one.y0 + static_cast<std::int32_t>(south << one_by_one.z),
                             one_by_one.z,
                             one_by_one.base,
                             one_by_one.unit_m};
                for (std::uint32_t row = 0; row < count; ++row)
                    for (std::uint32_t lane = 0; lane < page_squares; ++lane)
                        if (bits[n][row] >> lane & 1)
                            picked.push_back((first[n] + row * stride + lane) | (2 * lane + east) << 16 |
                                             std::uint64_t{2 * row + south} << 24);
            }
            one_by_one.count = static_cast<std::uint32_t>(picked.size());
            if (picked.empty()) continue;
            while (picked.size() % group_lanes != 0) picked.push_back(picked.back());
            one_by_one.picked = picked.data();
            std::vector<MeshVertex> plain(picked.size()), fast(picked.size() + group_lanes, MeshVertex{-1, -1, -1});
            std::vector<MorphVertex> plain_morph(picked.size()), fast_morph(fast.size(), MorphVertex{-1, -1, -1, -1});
            std::vector<std::uint8_t> voids(fast.size(), 7);
            place_picked(c, one_by_one, plain.data(), plain_morph.data());
            const std::uint32_t placed =
                place_rows(c, planes, 2, fast.data(), fast_morph.data(), round % 2 == 0 ? voids.data() : nullptr);
            REQUIRE(placed == one_by_one.count);
            REQUIRE(std::memcmp(plain.data(), fast.data(), placed * sizeof(MeshVertex)) == 0);
            REQUIRE(std::memcmp(plain_morph.data(), fast_morph.data(), placed * sizeof(MorphVertex)) == 0);
            REQUIRE((fast[placed].column == -1 && fast_morph[placed].error_m == -1));
            for (std::uint32_t n = 0; n < placed; ++n) {
                const std::uint8_t is = is_void(records[picked[n] & 0xffff]) ? 1 : 0;
                REQUIRE(voids[n] == (round % 2 == 0 ? is : 7));
                voids_seen += is;
            }
            REQUIRE(voids[placed] == 7);
        }
    });
    REQUIRE(voids_seen > 1000);
}
