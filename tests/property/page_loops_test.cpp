// How pages are decoded: the loops in vectors against the same one vertex at a time, and records against the format.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "pack/page_loops.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Bytes of one kind: any, small, or one value. Just as many as there are: one further is the sanitizer's.
std::unique_ptr<std::byte[]> random_bytes(Random& random, std::size_t count) {
    auto bytes = std::make_unique<std::byte[]>(count);
    const int most = pick(random, 0, 2) ? 255 : pick(random, 0, 3),
              only = pick(random, 0, 4) ? -1 : pick(random, 0, 255);
    for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(only < 0 ? pick(random, 0, most) : only);
    return bytes;
}

// Corners that lie on the page's surface, about it, or anywhere.
void random_corners(Random& random, const PageArrays& page, CornerSteps& corners) {
    const int kind = pick(random, 0, 3), rough = 1 << pick(random, 0, 13);
    for (std::int32_t& corner : corners) {
        const int near = page.base + page.heights[static_cast<std::size_t>(&corner - corners)];
        corner = kind == 0   ? near
                 : kind == 3 ? pick(random, 0, 1) * max_height_steps
                             : std::clamp(near + pick(random, -rough, rough), 0, max_height_steps);
    }
}

// The planes of five steps over a page, each in a step of just as many records as there are, at any place of it.
struct CoarserSteps {
    std::vector<VertexRecord> records[page_squares_log2];
    StepRows rows[page_squares_log2];
    explicit CoarserSteps(Random& random) {
        const auto order = pick(random, 0, 1) ? PageOrder::planar : PageOrder::hierarchical_z;
        for (int k = 0; k < page_squares_log2; ++k) {
            const auto squares = static_cast<std::uint32_t>(pick(random, k, page_squares_log2));
            const std::uint32_t side = 1u << squares, room = side - (1u << k);
            records[k].resize(3 * side * side + 2 * side);
            for (VertexRecord& r : records[k])
                r = {static_cast<std::uint16_t>(pick(random, 0, 65535)),
                     static_cast<std::uint8_t>(pick(random, 0, 255)), static_cast<std::uint8_t>(pick(random, 0, 255))};
            rows[k] = {records[k].data(),
                       pick(random, 0, max_height_steps - 65535),
                       side,
                       order,
                       static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(room))),
                       static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(room)))};
        }
    }
};

// What a page stores, by the order in docs/pack-format.md.
struct StoredPage {
    PageHead head{};
    const std::byte *low = nullptr, *high = nullptr, *errors = nullptr, *radii = nullptr, *holes = nullptr;
    StoredPage(const std::vector<std::byte>& raw, std::uint32_t count, bool step_page) {
        std::memcpy(&head, raw.data(), sizeof head);
        const std::byte* at = raw.data() + sizeof head;
        const auto take = [&](std::size_t bytes) { return at += bytes, at - bytes; };
        low = take(count);
        if (head.flags & page_wide) high = take(count);
        if (head.flags & page_errors) errors = take(count);
        radii = take(step_page ? page_radii : count);
        if (head.flags & page_voids) holes = take((count + 7) / 8);
    }
    [[nodiscard]] bool hole(std::uint32_t i) const {
        return holes != nullptr && ((std::to_integer<unsigned>(holes[i / 8]) >> (i % 8)) & 1) != 0;
    }
    // Of vertex i of a step page: one for 4 x 4 squares of its plane.
    [[nodiscard]] std::uint8_t shared_radius(std::uint32_t i) const {
        const auto in_plane = [&](std::uint32_t first, std::uint32_t vertex, std::uint32_t columns) {
            return static_cast<std::uint8_t>(
                radii[first + vertex / columns / 4 * ((columns + 3) / 4) + vertex % columns / 4]);
        };
        if (i < first_side_x) return in_plane(0, i, page_squares);
        if (i < first_side_y) return in_plane(64, i - first_side_x, page_squares);
        return in_plane(64 + 72, i - first_side_y, page_corners);
    }
};

// One page of a terrain that is loaded whole, decoded once more from its bytes, one vertex at a time.
class Reference {
public:
    Reference(const io::LoadedPack& pack, std::uint32_t tile, std::uint32_t page)
        : terrain_(data_of(pack.terrain)),
          pages_(terrain_.pages), planar_{pages_.tile_log2,
                                          pages_.order == PageOrder::linear ? PageOrder::linear : PageOrder::planar},
          page_(page), count_(pages_.page_vertices(page)), leaf_(terrain_.errors, terrain_.header.quantum_m) {
        const std::int32_t side = terrain_.tree.side();
        corner_ = {static_cast<std::int32_t>(tile % terrain_.header.tiles_x) * side,
                   static_cast<std::int32_t>(tile / terrain_.header.tiles_x) * side};
        entry_ = terrain_.page_table[std::size_t{tile} * terrain_.pages_per_tile + page];
        const ChunkId id{ChunkKind::geometry, tile, page};
        raw_.resize(pack.pack.entry(chunk_index(pack.pack.header, id)).raw_bytes);
        REQUIRE(read_chunk(pack.pack, id, raw_).ok());
    }

    // The number of records that are not what they should be.
    [[nodiscard]] std::size_t wrong() {
        const bool step_page = is_step_page(pages_, page_);
        const StoredPage stored(raw_, count_, step_page);
        expected_.base = stored.head.base;
        if (step_page)
            restore_heights_scalar(stored.low, stored.high, expected_.heights);
        else
            restore_rows(stored);
        if (stored.errors != nullptr)
            std::memcpy(expected_.errors, stored.errors, count_);
        else
            derive();
        std::vector<std::uint32_t> place(pages_.tile_vertices());
        for (std::uint32_t k = 0; k < count_; ++k) place[at(pages_.coord({page_, k}))] = k;
        std::size_t wrong = entry_.base != stored.head.base;
        for (std::uint32_t i = 0; i < count_; ++i) {
            expected_.radii[i] = step_page ? stored.shared_radius(i) : std::to_integer<std::uint8_t>(stored.radii[i]);
            if (stored.hole(i)) expected_.radii[i] |= void_bit;
            const VertexRecord r =
                terrain_.records[std::size_t{entry_.slot} * terrain_.page_capacity + place[at(coord(i))]];
            wrong +=
                r.height != expected_.heights[i] || r.error != expected_.errors[i] || r.radius != expected_.radii[i];
        }
        return wrong;
    }
    [[nodiscard]] bool derived() const { return (std::to_integer<unsigned>(raw_[4]) & page_errors) == 0; }
    [[nodiscard]] bool holed() const { return (std::to_integer<unsigned>(raw_[4]) & page_voids) != 0; }

private:
    // Of the vertex that is stored as number i: pages store planar order, whatever they are decoded to.
    [[nodiscard]] SampleIndex coord(std::uint32_t i) const {
        if (!is_step_page(pages_, page_)) return planar_.coord({page_, i});
        const SampleIndex p = pages_.page_position(page_);
        return planar_.coord({planar_.page_at(pages_.page_step_log2(page_), static_cast<std::uint32_t>(p.column),
                                              static_cast<std::uint32_t>(p.row)),
                              i});
    }
    [[nodiscard]] std::size_t at(SampleIndex c) const {
        return static_cast<std::size_t>(c.row * (terrain_.tree.side() + 1) + c.column);
    }
    void restore_rows(const StoredPage& stored) {
        const std::uint32_t row = row_length(pages_);
        std::uint16_t* const h = expected_.heights;
        for (std::uint32_t i = 0; i < count_; ++i) {
            const unsigned folded = std::to_integer<unsigned>(stored.low[i]) |
                                    (stored.high ? std::to_integer<unsigned>(stored.high[i]) << 8 : 0);
            int predicted = i == 0 ? 0 : h[i - 1];
            if (row != 0 && i > row) predicted += h[i - row] - h[i - row - 1];
            h[i] = static_cast<std::uint16_t>(
                predicted + (folded % 2 ? -static_cast<int>(folded / 2) - 1 : static_cast<int>(folded / 2)));
        }
    }
    void derive() {
        const SampleIndex p = pages_.page_position(page_);
        static CornerSteps corners;
        for (std::int32_t j = 0; j <= static_cast<std::int32_t>(page_squares); ++j)
            for (std::int32_t i = 0; i <= static_cast<std::int32_t>(page_squares); ++i)
                corners[static_cast<std::size_t>(j) * page_corners + static_cast<std::size_t>(i)] =
                    terrain_
                        .vertex({corner_.column + 2 * (p.column * static_cast<std::int32_t>(page_squares) + i),
                                 corner_.row + 2 * (p.row * static_cast<std::int32_t>(page_squares) + j)})
                        .steps;
        leaf_errors_scalar(corners, terrain_.errors.nesting_steps, leaf_, expected_);
    }

    const TerrainData& terrain_;
    PageLayout pages_, planar_;
    std::uint32_t page_, count_;
    LeafErrors leaf_;
    SampleIndex corner_;
    PageEntry entry_;
    std::vector<std::byte> raw_;
    PageArrays expected_;
};

} // namespace

TEST_CASE("a page's loops do in vectors what they do one vertex at a time, bit for bit") {
    Random random(141);
    const auto a = std::make_unique<PageArrays>(), b = std::make_unique<PageArrays>();
    const auto corners = std::make_unique<CornerSteps[]>(1);
    std::vector<LeafErrors> leaves;
    for (const float quantum_m : {0.1f, 1e-9f, 1e4f}) leaves.emplace_back(ErrorScale::make(0.05f, 1.05f, 1), quantum_m);
    std::size_t far = 0;
    for (int round = 0; round < rounds(150, 10'000); ++round) {
        const auto low = random_bytes(random, max_page_vertices), high = random_bytes(random, max_page_vertices);
        const bool wide = pick(random, 0, 1) == 1;
        restore_heights(low.get(), wide ? high.get() : nullptr, a->heights);
        restore_heights_scalar(low.get(), wide ? high.get() : nullptr, b->heights);
        REQUIRE(std::equal(std::begin(a->heights), std::end(a->heights), b->heights));

        a->base = b->base = pick(random, 0, 2) * ((max_height_steps - 65535) / 2);
        random_corners(random, *a, corners[0]);
        const LeafErrors& leaf = leaves[static_cast<std::size_t>(pick(random, 0, 2))];
        const auto nesting_steps = static_cast<std::uint32_t>(pick(random, 0, 3) ? pick(random, 1, 14) : 255);
        leaf_errors(corners[0], nesting_steps, leaf, *a);
        leaf_errors_scalar(corners[0], nesting_steps, leaf, *b);
        REQUIRE(std::equal(std::begin(a->errors), std::end(a->errors), b->errors));
        far += std::abs(2 * (a->base + a->heights[0]) - corners[0][0] - corners[0][page_corners + 1]) >=
               static_cast<int>(LeafErrors::table_size);

        for (std::uint8_t& r : a->radii) r = static_cast<std::uint8_t>(pick(random, 0, 255));
        const auto count =
            pick(random, 0, 2) ? static_cast<std::uint32_t>(pick(random, 0, max_page_vertices)) : max_page_vertices;
        const auto first = static_cast<std::size_t>(pick(random, 0, 3)); // slots of small tiles are not aligned
        std::vector<VertexRecord> to(first + count + 1, VertexRecord{1, 2, 3}), to_scalar = to;
        write_page(*a, count, to.data() + first);
        write_page_scalar(*a, count, to_scalar.data() + first);
        REQUIRE(std::memcmp(to.data(), to_scalar.data(), to.size() * sizeof(VertexRecord)) == 0);
        REQUIRE(std::memcmp(&to.back(), std::array<std::uint8_t, 4>{1, 0, 2, 3}.data(), sizeof(VertexRecord)) == 0);
    }
    CHECK(far > 10);
}

TEST_CASE("a page's corners and radii are the same in vectors and one vertex at a time, wherever coarser steps lie") {
    Random random(143);
    const auto a = std::make_unique<CornerSteps[]>(2);
    const auto radii = std::make_unique<std::uint8_t[]>(max_page_vertices),
               radii_scalar = std::make_unique<std::uint8_t[]>(max_page_vertices);
    for (int round = 0; round < rounds(150, 5'000); ++round) {
        const CoarserSteps coarser(random);
        std::int32_t own[4];
        for (std::int32_t& steps : own) steps = pick(random, 0, max_height_steps);
        for (int k = 0; k < 2; ++k)
            std::fill(std::begin(a[static_cast<std::size_t>(k)]), std::end(a[static_cast<std::size_t>(k)]), -1 - k);
        refine_corners(own, coarser.rows, a[0]);
        refine_corners_scalar(own, coarser.rows, a[1]);
        REQUIRE(std::equal(std::begin(a[0]), std::end(a[0]), a[1]));
        REQUIRE(*std::min_element(std::begin(a[1]), std::end(a[1])) >= 0); // all of them are set

        const auto stored = random_bytes(random, page_radii);
        const auto* const codes = reinterpret_cast<const std::uint8_t*>(stored.get());
        expand_radii(codes, radii.get());
        expand_radii_scalar(codes, radii_scalar.get());
        REQUIRE(std::equal(radii.get(), radii.get() + max_page_vertices, radii_scalar.get()));
    }
}

TEST_CASE("a page's records are what the pack's format says, whatever the order, the rim and the holes") {
    Random random(142);
    int derived = 0, holed = 0;
    for (int round = 0; round < rounds(9, 90); ++round) {
        const bool rugged = round < 3; // and whole tiles: errors of all of its finest pages follow from heights
        const int log2 = rugged ? 7 : pick(random, 1, 8), most = log2 == 8 ? 400 : 3 << log2;
        const auto shape = static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1));
        baker::Dem dem = rugged ? random_dem(random, 257, 257, Shape::noise)
                                : random_dem(random, pick(random, 2, most), pick(random, 2, most), shape);
        if (!rugged && round % 3 != round % 2) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(round % 3);
        const io::LoadedPack pack = bake_and_load(std::move(dem), options);
        CAPTURE(round, log2, static_cast<int>(options.order));
        for (std::uint32_t tile = 0; tile < pack.terrain.tile_count(); ++tile)
            for (std::uint32_t page = 0; page < pack.terrain.pages_per_tile(); ++page) {
                Reference reference(pack, tile, page);
                CAPTURE(tile, page);
                REQUIRE(reference.wrong() == 0);
                derived += rugged && reference.derived();
                holed += reference.holed();
            }
    }
    CHECK(derived == 2 * 16); // linear order derives none
    CHECK(holed > 5);
}
